"""Hand the Markdown files of the repository to mkdocs where they are, under their own paths.

A hook of mkdocs.yml. The site has the folders of the repository, so a relative link between two files means
the same in both. PAGES lists the pages in the order of the menu; a pattern takes its files in the order of
their names.
"""

from __future__ import annotations

from pathlib import Path

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files

ROOT = Path(__file__).resolve().parents[1]

PAGES: dict[str, tuple[str, ...]] = {
    "Start": ("README.md",),
    "Specification": ("spec/README.md", "spec/*.md"),
    "Visibility, proved": ("docs/visibility.md",),
    "Encoder": ("docs/encoder.md",),
    "Validator": ("validator/README.md",),
    "Conformance": ("conformance/README.md",),
    "Benchmarks": ("benchmarks/README.md",),
    "Contributing": ("CONTRIBUTING.md", "CHANGELOG.md"),
    "Decisions": ("docs/decisions/README.md", "docs/decisions/0*.md"),
}
OTHER_FILES = (
    "LICENSE",
    "docs/**/*.svg",
    "spec/**/*.svg",
    "spec/*.toml",
    "schema/*.json",
    "conformance/cases/**/case.json",
)
"""Files that pages refer to."""


def found(patterns: tuple[str, ...]) -> list[str]:
    """Paths of the files that match, relative to the repository, each once."""
    paths = [path for pattern in patterns for path in sorted(ROOT.glob(pattern)) if path.is_file()]
    return list(dict.fromkeys(path.relative_to(ROOT).as_posix() for path in paths))


def on_config(config: MkDocsConfig) -> MkDocsConfig:
    """Make the menu of the pages that exist."""
    menu = {title: found(patterns) for title, patterns in PAGES.items()}
    config.nav = [{title: pages[0] if len(pages) == 1 else pages} for title, pages in menu.items() if pages]
    return config


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Replace the files of docs/ by those of the repository; keep what the theme brings."""
    kept = [file for file in files if not (file.abs_src_path or "").startswith(config.docs_dir)]
    patterns = (*(pattern for patterns in PAGES.values() for pattern in patterns), *OTHER_FILES)
    plain = config.use_directory_urls
    ours = [File(path, str(ROOT), config.site_dir, use_directory_urls=plain) for path in found(patterns)]
    return Files([*kept, *ours])
