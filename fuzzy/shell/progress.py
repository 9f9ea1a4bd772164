"""The progress bar of long work, on stderr."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Protocol


class Advance(Protocol):
    """A function that advances a task by one step, and may change its description."""

    def __call__(self, description: str | None = None) -> None: ...  # noqa: D102


class Begin(Protocol):
    """A function that begins a task of ``total`` steps and returns what advances it by one step."""

    def __call__(self, description: str, total: int) -> Advance: ...  # noqa: D102


def unwatched(description: str, total: int) -> Advance:
    """Begin a task of which no progress is shown."""
    return lambda description=None: None


class Mover:
    """Moves a bar to a number of steps, by what advances it by one; never back."""

    def __init__(self, advance: Advance) -> None:
        self.advance, self.done = advance, 0

    def __call__(self, done: int, description: str | None = None) -> None:
        """Move it to ``done`` steps."""
        for _ in range(done - self.done):
            self.advance(description)
        self.done = max(done, self.done)


@contextmanager
def progress_bar(quiet: bool, width: int = 32) -> Iterator[Begin]:
    """A progress bar on stderr, for a ``with`` block: gives a function that begins a task.

    That function returns what advances the task by one step. ``width`` is that of the descriptions, in characters.
    """
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

    columns = (TextColumn(f"{{task.description:{width}}}"), BarColumn(), TextColumn("{task.percentage:>3.0f} %"))
    console = Console(stderr=True)
    with Progress(*columns, TimeRemainingColumn(), console=console, disable=quiet) as progress:

        def begin(description: str, total: int) -> Advance:
            task = progress.add_task(description, total=total)
            every = max(1, total // 200)  # a bar has no use for more
            count = 0

            def advance(description: str | None = None) -> None:
                nonlocal count
                count += 1
                if count % every == 0 or count == total:
                    progress.update(task, completed=count, description=description)

            return advance

        try:
            yield begin
        except BaseException:
            progress.live.transient = True  # what stands there is then the sentence that says it
            raise
