"""The places where pages find the ES modules and style sheets of installed packages."""

from pathlib import Path
from urllib.parse import quote


class Modules:
    """The ES modules and style sheets that pages may load: those of packages whose modules are shown."""

    def __init__(self) -> None:
        self._roots: dict[str, Path] = {}
        self.url(Path(__file__))

    def url(self, file: Path) -> str:
        """The address of a file of an installed package: /modules/PACKAGE/PATH IN THE PACKAGE."""
        file = file.resolve()
        # Folders of modules need not be packages themselves: the topmost package counts.
        packages = [folder for folder in file.parents if (folder / "__init__.py").is_file()]
        root = packages[-1] if packages else file.parent
        self._roots[root.name] = root
        return f"/modules/{quote(root.name)}/{quote(file.relative_to(root).as_posix())}"

    def file(self, package: str, path: str) -> Path | None:
        """The file at such an address; None where no page may have it."""
        root = self._roots.get(package)
        if root is None or "\0" in path:
            return None
        file = (root / path).resolve()
        allowed = file.suffix in (".js", ".css") and file.is_relative_to(root) and file.is_file()
        return file if allowed else None
