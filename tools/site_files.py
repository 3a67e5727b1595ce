"""Hand the Markdown files of the repository to mkdocs where they are, under their own paths.

A hook of mkdocs.yml. The site has the folders of the repository, so a relative link between two files means
the same in both; a file that a page links to is on the site too. PAGES lists the pages in the order of the
menu; a pattern takes its files in the order of their names.
"""

from __future__ import annotations

import re
from pathlib import Path

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files

ROOT = Path(__file__).resolve().parents[1]

PAGES: dict[str, tuple[str, ...]] = {
    "Start": ("README.md",),
    "Specification": ("spec/README.md", "spec/*.md"),
    "Visibility, proved": ("docs/visibility.md",),
    "Levels of detail": ("docs/lod.md",),
    "Encoder": ("docs/encoder.md",),
    "Bandwidth along a route": ("docs/path.md",),
    "Packets": ("docs/packets.md",),
    "LiDAR": ("docs/lidar.md",),
    "Validator": ("validator/README.md",),
    "Conformance": ("conformance/README.md",),
    "Benchmarks": ("benchmarks/README.md",),
    "Contributing": ("CONTRIBUTING.md", "CHANGELOG.md"),
    "Decisions": ("docs/decisions/README.md", "docs/decisions/0*.md"),
}
FENCE_VERDICT = re.compile(r"^(```\w+) .+$", re.MULTILINE)
"""Blocks of the specification carry the verdict they must get; mkdocs knows only the language before it."""
LINK = re.compile(r"\]\(([^)\s#]+)")


def found(patterns: tuple[str, ...]) -> list[str]:
    """Paths of the files that match, relative to the repository, each once."""
    paths = [path for pattern in patterns for path in sorted(ROOT.glob(pattern)) if path.is_file()]
    return list(dict.fromkeys(path.relative_to(ROOT).as_posix() for path in paths))


def linked(page: str) -> list[str]:
    """Files of the repository that a page links to: pictures, cases, sources."""
    place = (ROOT / page).parent
    links = LINK.findall((ROOT / page).read_text(encoding="utf-8"))
    targets = [(place / link).resolve() for link in links if (place / link).is_file()]
    return [path.relative_to(ROOT).as_posix() for path in targets if path.is_relative_to(ROOT)]


def on_config(config: MkDocsConfig) -> MkDocsConfig:
    """Make the menu of the pages that exist."""
    menu = {title: found(patterns) for title, patterns in PAGES.items()}
    config.nav = [{title: pages[0] if len(pages) == 1 else pages} for title, pages in menu.items() if pages]
    return config


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Replace the files of docs/ by those of the repository; keep what the theme brings."""
    kept = [file for file in files if not (file.abs_src_path or "").startswith(config.docs_dir)]
    pages = [page for patterns in PAGES.values() for page in found(patterns)]
    paths = dict.fromkeys([*pages, *(target for page in pages for target in linked(page))])
    plain = config.use_directory_urls
    ours = (File(path, str(ROOT), config.site_dir, use_directory_urls=plain) for path in paths)
    return Files([*kept, *ours])


def on_page_markdown(markdown: str, **_: object) -> str:
    """Take the verdicts from the fences."""
    return FENCE_VERDICT.sub(r"\1", markdown)
