"""The progress bar of long work, on stderr."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager

# Begin a task of so many steps: what comes back advances it by one
Begin = Callable[[str, int], Callable[[], None]]


@contextmanager
def progress_bar(quiet: bool) -> Iterator[Begin]:
    """A progress bar on stderr: gives a function that begins a task and returns what advances it by one."""
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

    columns = (TextColumn("{task.description:32}"), BarColumn(), TextColumn("{task.percentage:>3.0f} %"))
    console = Console(stderr=True)
    with Progress(*columns, TimeRemainingColumn(), console=console, disable=quiet) as progress:

        def begin(description: str, total: int) -> Callable[[], None]:
            task = progress.add_task(description, total=total)
            every = max(1, total // 200)  # a bar has no use for more
            count = 0

            def advance() -> None:
                nonlocal count
                count += 1
                if count % every == 0 or count == total:
                    progress.update(task, completed=count)

            return advance

        yield begin
