"""Ctrl-C, SIGTERM and a full disk in a command line."""

import errno
import signal
import time

import pytest
import typer

from fuzzy.shell.interrupts import interrupted
from fuzzy.shell.terminal import application, run


def of(command):
    app = application("A command line.")
    app.command()(command)
    return run(app, "it", [])


@pytest.mark.parametrize(
    ("number", "code", "said"),
    [(signal.SIGINT, 130, "it: interrupted\n"), (signal.SIGTERM, 143, "it: interrupted by SIGTERM\n")],
)
def test_a_signal_is_one_sentence_and_the_handlers_come_back(number, code, said, capsys):
    before = signal.getsignal(number)
    assert of(lambda: signal.raise_signal(number)) == code
    assert capsys.readouterr().err == said
    assert signal.getsignal(number) is before


def test_who_keeps_something_says_it(capsys):
    def keeps():
        try:
            signal.raise_signal(signal.SIGTERM)
        except KeyboardInterrupt:
            interrupted("3 of 5 are kept")

    assert of(keeps) == 143
    assert capsys.readouterr().err == "it: interrupted by SIGTERM; 3 of 5 are kept\n"


def test_an_interrupt_that_a_library_drops_comes_again(capsys):
    class Drops:
        def __del__(self):  # as in a callback of C, an exception has nowhere to go
            signal.raise_signal(signal.SIGINT)

    def long():
        Drops()
        for _ in range(500):
            time.sleep(0.01)

    assert of(long) == 130
    assert capsys.readouterr().err == "it: interrupted\n"


def test_an_interrupt_that_a_library_translates_is_one(capsys):
    def translates():
        try:
            raise KeyboardInterrupt
        except KeyboardInterrupt as error:
            raise SystemError("returned a result with an exception set") from error

    assert of(translates) == 130
    assert capsys.readouterr().err == "it: interrupted\n"


def test_what_a_signal_takes_from_our_processes_is_no_fault_of_its_own(capsys):
    def misses():
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(signal.SIGTERM)
        raise FileNotFoundError(errno.ENOENT, "No such file or directory")

    assert of(misses) == 143
    assert capsys.readouterr().err == "it: interrupted by SIGTERM\n"


def test_a_file_that_cannot_be_written_after_a_signal_is_told(capsys):
    def loses():
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(signal.SIGINT)
        raise PermissionError(errno.EACCES, "Permission denied", "kept.csv")

    assert of(loses) == 2
    assert capsys.readouterr().err == "it: kept.csv: Permission denied\n"


def test_a_full_disk_behind_stdout_is_a_sentence(capsys, monkeypatch):
    def full():
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr("fuzzy.shell.terminal._drop_output", lambda: None)
    assert of(full) == 2
    assert capsys.readouterr().err == "it: standard output: No space left on device\n"


def test_an_exit_code_of_a_command_stays(capsys):
    def leaves():
        raise typer.Exit(1)

    assert of(leaves) == 1
    assert capsys.readouterr().err == ""
