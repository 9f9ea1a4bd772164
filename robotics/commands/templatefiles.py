"""Files of one's own that are no TOML: a law, a metric, a rule base, each to begin with and to be changed."""

from importlib import resources
from pathlib import Path

from fuzzy.errors import InputError
from fuzzy.files.atomic import write_whole
from fuzzy.naming import expected

# By kind: the packaged file, the name by which its own comments call it, and the command that uses it
TEMPLATES: dict[str, tuple[str, str, str]] = {
    "law": ("law.py", "mylaw.py", "robotics run lyapunov-sine --law FILE:MyLaw"),
    "metric": ("metric.py", "mymetric.py", "robotics run lyapunov-sine --metric FILE:comfort"),
    "rule-base": ("rule-base.fis", "mine.fis", "robotics run lyapunov-sine -c FILE"),
}


def template_text(kind: str, file: str = "") -> str:
    """The commented template of a kind, whose comments call it ``file``. Raises InputError for an unknown kind."""
    if kind not in TEMPLATES:
        raise InputError(expected(kind, TEMPLATES, "kind of file"))
    packaged, name, _ = TEMPLATES[kind]
    text = (resources.files("robotics") / "data" / "templates" / packaged).read_text(encoding="utf-8")
    return text.replace(name, file or name)


def write_template(kind: str, path: Path) -> str:
    """Write the template of a kind to a file, whole or not at all; return the command that uses it.

    Raises InputError for an unknown kind or a wrong ending, and OSError.
    """
    text, suffix = template_text(kind, str(path)), Path(TEMPLATES[kind][0]).suffix
    if path.suffix != suffix:
        raise InputError(f"{path}: the name of a {kind} file must end in {suffix}")
    write_whole(path, text)
    return TEMPLATES[kind][2].replace("FILE", str(path))
