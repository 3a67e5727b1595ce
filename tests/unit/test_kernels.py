"""The cache of machine code follows the sources, and kernels stay inside their package."""

import ast
import builtins
from pathlib import Path

import numba
import pytest

import tilesnav_ref
from tilesnav_ref import kernels

PACKAGE = Path(tilesnav_ref.__file__).parent
FILES = sorted(p for p in PACKAGE.rglob("*.py") if "@kernel" in p.read_text() and p.name != "kernels.py")
SHARED = {"numpy", "math", "numba", "__future__", "typing", "heapq"}


def imported_from_elsewhere(tree: ast.Module, own: str) -> set[str]:
    names = set()
    for node in tree.body:
        if isinstance(node, ast.ImportFrom) and node.module and node.module.split(".")[0] not in SHARED:
            if not node.module.startswith(own):
                names |= {alias.asname or alias.name for alias in node.names}
        elif isinstance(node, ast.Import):
            names |= {a.asname or a.name for a in node.names if a.name.split(".")[0] not in SHARED}
    return names - {"kernel"}


def is_kernel(node: ast.stmt) -> bool:
    return isinstance(node, ast.FunctionDef) and any(
        isinstance(d, ast.Name) and d.id == "kernel" for d in node.decorator_list
    )


@pytest.mark.parametrize("path", FILES, ids=lambda p: f"{p.parent.name}/{p.name}")
def test_kernels_use_names_of_their_own_package_only(path):
    own = ".".join(("tilesnav_ref", *path.relative_to(PACKAGE).parts[:-1]))
    tree = ast.parse(path.read_text())
    foreign = imported_from_elsewhere(tree, own) - set(dir(builtins))
    for node in filter(is_kernel, tree.body):
        used = {n.id for n in ast.walk(node) if isinstance(n, ast.Name)}
        assert not used & foreign, node.name


def test_there_are_kernels_to_look_at():
    assert len(FILES) > 5


def test_every_compiled_function_goes_through_the_decorator():
    others = [p for p in PACKAGE.rglob("*.py") if "njit" in p.read_text() and p.name != "kernels.py"]
    assert others == []


def test_the_cache_folder_changes_with_any_source_of_the_package(tmp_path, monkeypatch):
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "cache"))
    package = tmp_path / "shapes"
    package.mkdir()
    (package / "a.py").write_text("x = 1\n")
    (package / "b.py").write_text("y = 1\n")
    fresh = kernels.cache_folder.__wrapped__
    first = fresh(package)
    assert first == fresh(package)
    (package / "b.py").write_text("y = 2\n")
    second = fresh(package)
    assert second != first
    assert second.is_dir()


def test_a_folder_that_cannot_be_written_only_costs_the_cache(tmp_path, monkeypatch, caplog):
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "file"))
    assert kernels.cache_folder.__wrapped__(PACKAGE) is None
    assert "compiled anew" in caplog.text


def test_the_setting_of_other_packages_is_left_alone():
    before = numba.config.CACHE_DIR

    @kernels.kernel
    def one(x):
        return x + 1

    assert one(1) == 2
    assert before == numba.config.CACHE_DIR
