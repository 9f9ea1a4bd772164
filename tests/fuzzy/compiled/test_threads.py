"""Work shared out over threads: every job once, results in order, the first error, and no deadlock."""

import threading
import time

import pytest

from fuzzy.compiled.threads import share_out


@pytest.mark.parametrize("threads", [None, 0, 1, 2, 7])
@pytest.mark.parametrize("count", [0, 1, 5, 200])
def test_every_job_is_done_once_and_its_result_stands_in_its_place(count, threads):
    done = []
    assert share_out(lambda job: done.append(job) or job**2, range(count), threads) == [k**2 for k in range(count)]
    assert sorted(done) == list(range(count))


def test_two_threads_work_at_a_time():
    both = threading.Barrier(2)
    share_out(lambda _: both.wait(60), range(2), 2)  # breaks if the two jobs are not done at the same time


@pytest.mark.parametrize("threads", [1, 2])
def test_the_error_of_the_first_job_that_failed_is_raised_and_no_more_are_begun(threads):
    begun = []

    def one(job):
        begun.append(job)
        if job >= 3:
            time.sleep(0.02 if job == 3 else 0.0)  # the later one fails first
            raise ValueError(f"job {job}")
        return job

    with pytest.raises(ValueError, match="job 3"):
        share_out(one, range(1000), threads)
    assert len(begun) <= 3 + threads


def test_an_interrupt_waits_for_the_jobs_that_were_begun():
    running = []

    def one(job):
        running.append(job)
        if threading.current_thread() is threading.main_thread():
            raise KeyboardInterrupt
        time.sleep(0.05)
        running.remove(job)

    with pytest.raises(KeyboardInterrupt):
        share_out(one, range(50), 2)
    assert len(running) == 1  # that of this thread


def test_a_job_may_share_out_work_of_its_own():
    def one(job):
        return sum(share_out(lambda inner: job * inner, range(20), 4))

    assert share_out(one, range(30), 4) == [190 * job for job in range(30)]
