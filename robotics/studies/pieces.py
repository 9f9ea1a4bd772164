"""Work in pieces: handed out to whoever does it, given back as it gets done, and kept in a folder, a file a piece.

Comparisons, sweeps, stress tests, searches, arenas and the thesis's chapters are made of pieces. :func:`run_pieces`
does them, and says in one way which piece failed; :func:`kept_piece` reads what is there already.
"""

import warnings
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, CancelledError, Future, wait
from itertools import islice
from pathlib import Path
from time import monotonic
from typing import TypeVar

from fuzzy.errors import InputError
from fuzzy.shell.interrupts import raise_interrupt
from robotics.studies.executors import WorkerError, Workers

_PATIENCE = 5.0  # s that a cluster may be without workers before it is said
_GOES_ON = "; the same command goes on from there"

Piece = TypeVar("Piece")
Result = TypeVar("Result")


def run_pieces(
    one: Callable[[Piece], Result],
    pieces: Iterable[Piece],
    workers: Workers | None = None,
    *,
    called: Callable[[Piece], str] = lambda piece: "",
    kept: type[InputError] | None = None,
    lost: Callable[[WorkerError], None] | None = None,
    ordered: bool = False,
    advance: Callable[[], None] | None = None,
) -> Iterator[tuple[Piece, Result]]:
    """Do pieces of work; each comes with its result as it gets done. The first are handed out at once.

    It warns once if nobody is there to do the work for some seconds.

    Args:
        one: Does a piece; workers elsewhere are given it as a pickle.
        pieces: The pieces, in the order in which they are handed out.
        workers: Who does the work, by default this process.
        called: What messages call a piece; by default they do not name it.
        kept: Where what is done is kept, so that the same command goes on from there: the error of a piece that fails,
            which names it. Otherwise what went wrong in a piece comes as it was raised.
        lost: Called where workers have died over a piece, and the others go on; by default this is raised.
        ordered: Whether they come in the order of ``pieces``.
        advance: Called after each piece.

    Raises:
        WorkerError: Workers have died over a piece, or cannot be reached any more; ``kept`` in its place.
    """
    workers = workers or Workers()
    waiting, flying = iter(pieces), dict[Future[Result], Piece]()

    def hand_out() -> None:
        for piece in islice(waiting, workers.in_flight - len(flying)):
            flying[workers.executor.submit(one, piece)] = piece

    def results() -> Iterator[tuple[Piece, Result]]:
        since, told = monotonic(), False  # when there was last somebody to do the work; whether it was said
        while flying:
            done = wait(list(flying)[:1] if ordered else flying, timeout=1.0, return_when=FIRST_COMPLETED).done
            if not done and not workers.alive():
                raise _unreachable(kept)
            idle = "" if done else workers.idle()
            since = since if idle else monotonic()
            if idle and not told and monotonic() - since > _PATIENCE:
                told = True
                warnings.warn(idle, stacklevel=2)
            for future in done:
                piece = flying.pop(future)
                try:
                    result = _result(future, called(piece), kept)
                except WorkerError as error:
                    if lost is None:
                        raise
                    lost(error)
                else:
                    yield piece, result
                if advance is not None:
                    advance()
            hand_out()

    hand_out()
    return results()


def _unreachable(kept: type[InputError] | None) -> InputError:
    return (kept or WorkerError)(f"the connection to the cluster is lost{_GOES_ON if kept else ''}")


def _result(future: "Future[Result]", called: str, kept: type[InputError] | None) -> Result:
    """The result of a piece that is ``called`` so; raises what is said of one that has none."""
    place = f"{called}: " if called else ""
    try:
        return future.result()
    except WorkerError as error:
        raise (kept or WorkerError)(f"{place}{error}{_GOES_ON if kept else ''}") from None
    except (CancelledError, BrokenExecutor):
        raise _unreachable(kept) from None
    except Exception as error:
        raise_interrupt(error)
        if kept is None or isinstance(error, kept):
            raise
        said = str(error) if isinstance(error, InputError) else f"{type(error).__name__}: {error}"
        raise kept(f"{place}{said}") from error


def kept_piece(path: Path, read: Callable[[Path], Result | None], kind: str) -> Result | None:
    """The result of a piece that is done, from its file; None: it has none, or one that cannot be used, which is said.

    Args:
        path: The file.
        read: What is in it; None: it is damaged, or of another piece.
        kind: What messages call the work: "sweep".
    """
    found = read(path) if path.exists() else None
    if found is None and path.exists():
        warnings.warn(f"{path} is damaged, or is not of this {kind}; it is computed again", stacklevel=2)
    return found
