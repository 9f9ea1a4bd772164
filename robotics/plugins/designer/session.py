"""The trials of one page of the panel "Try it": what was chosen, what is run, and what the page is shown.

The page shows what :class:`TryoutSession` hands to the module ``static/tryout.js``. Runs are made in the background,
one at a time: while one is made, only the latest wish waits.
"""

import asyncio
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import asdict, replace
from functools import partial
from itertools import count
from pathlib import Path
from time import monotonic
from typing import Any

from fuzzy.errors import InputError
from fuzzy.files.fisfile import read_fis
from fuzzy.naming import check_known
from fuzzy.plugins.designer.folder import check_size
from fuzzy.plugins.designer.latest import Postponed
from fuzzy.plugins.designer.panel import head_start
from fuzzy.plugins.designer.session import act_of, refusal_of
from fuzzy.plugins.designer.workers import WorkError
from fuzzy.system import Sugeno
from robotics.plugins.designer import folderfiles, severalseeds, tryout
from robotics.plugins.designer.conditions import packaged_text
from robotics.plugins.designer.folderfiles import FolderSession, FolderText, TextDesk
from robotics.plugins.designer.moments import RunMoments, rule_times
from robotics.plugins.designer.severalseeds import COUNTS, SeedRounds, Work
from robotics.plugins.designer.tryout import TryoutTrial
from robotics.plugins.designer.uses import TryoutError

# The first things to look at are made first
_ORDER = ("check", "course", "tried", "choices", "before", "rival", "rules")
_RUNS = {"tried", "before", "rival"}
_REST = 0.8  # s after a run in which nothing else was wanted, until it is found which rule ruled when
_SAID = 0.1  # s after which it is said what is being run: a drag's runs are shorter, and nothing is drawn for that
_KEPT = 32  # runs of rivals
_CHOICES = (
    "scenario",
    "law",
    "look_ahead",
    "seed",
    "robot",
    "robot_of",
    "noise",
    "given",
    "count",
    "shown",
    "rival",
    "beside",
)
_HIDDEN = ("text", "robot_text", "folder")  # what the page needs not know of a trial
_MODULE = Path(__file__).parent / "static" / "tryout.js"


class TryoutSession(FolderSession):
    """The trials of one page: the choices, the runs that are known, and those that are still to be made.

    A drag runs one seed; several are run once nothing else is wanted, see :class:`SeedRounds`.
    """

    error = TryoutError

    def __init__(self, bench: Any) -> None:
        super().__init__(bench)
        # What was chosen; what is empty is chosen to suit the system
        self.wish = TryoutTrial(folder=str(self.folder.path))
        self.trial: TryoutTrial | None = None  # what follows from it; none: the system or the scenario is no good
        self.rival = ""  # empty: what suits the system
        self.beside = False  # its run is played beside that of the design
        self.needs: str | None = None  # the group of scenarios for which law and rival were chosen; none: that to come
        # The system to compare with until another is chosen: that of the file, from which the present one may differ.
        # A new system has no file, and one may have been spoilt meanwhile.
        self.before, self.label = self.present, "as opened"
        self.opening: asyncio.Task[None] | None = None  # reads the file, once the panel is seen
        self.course: dict[str, Any] = {}  # of the place that the system has found
        self.variables: Any = None  # those of the system that found this place
        self.last: tuple[Any, ...] = ()  # the latest run: its trial, its system, and what is shown of it
        self.known: dict[tuple[Any, ...], dict[str, Any]] = {}  # runs of rivals
        self.took: dict[str, float] = {}  # s that making each thing took last
        self.choices: dict[str, Any] | None = None
        self.desks: dict[str, TextDesk] = {}  # the texts under edit, by "scenario" and "robot"
        self.open = ""  # the one that the page shows
        self.copies = count(1)  # of the texts that were laid on a desk
        # Of the folder's file that was chosen to compare with: its system, its law's specification, or why it has none
        self.rival_found: Sugeno | str | InputError | None = None
        self.wanted = set(_ORDER) - {"check", "rules"}
        self.task: asyncio.Task[None] | None = None
        self.doing = ""  # what the task runs
        self.saying = Postponed(_SAID, self._say_doing)
        self.moments = RunMoments(bench)
        self.ruling = Postponed(_REST, self._want_rules)  # waits until the design rests
        self.weighed: Sugeno | None = None  # the system of which it was asked what each rule is worth
        self.rounds = SeedRounds(bench.background, self._work, self._progress, self._publish)
        files: dict[str, list[str]] = {"scenarios": [], "robots": [], "laws": []}
        later = dict.fromkeys((*_ORDER[1:], "busy", "editor", "seeds", "round", "moment"))
        self.put(_MODULE, files=files, trial=self._trial(), **later)

    # Messages

    def heard(self, message: Any) -> None:
        """Do what the page asks, at once, and run what is wanted then."""
        content = message if isinstance(message, dict) else {}
        with self.refusing(content):
            self.act(content)
        self.go()

    def begin(self) -> None:
        """Leave what was refused on the page until the next run."""

    def refuse(self, error: Exception, message: Mapping[str, Any]) -> None:
        """Say on the page why nothing came of a message, and what is still chosen."""
        self.widget.update(problem=refusal_of(error, message), trial=self._trial())

    def _do_see(self, content: dict[str, Any]) -> None:
        self.seen = bool(content.get("on"))
        if self.seen:
            if self.opening is None:
                self.opening = self.begin_reading("before", self._open_before)
            self.list_files(content)
            self._look()

    def _do_weigh(self, _: dict[str, Any]) -> None:
        self.weighed = self.present
        self.rounds.wake()

    def _do_time(self, content: dict[str, Any]) -> None:
        self.widget.update(moment={"count": content.get("count")})  # whatever becomes of it, the page asks again
        self.widget.update(moment=self.moments.look(content))

    async def _open_before(self, mine: object) -> None:
        path = self.bench.document.path
        with suppress(InputError, WorkError):
            system = await self.bench.read(path.name, _system_in, path)
            if self.reads["before"] is mine:
                self.before, self.label = system, "in the file"

    def _do_pin(self, _: dict[str, Any]) -> None:
        self.reads["before"] = object()
        self.before, self.label = self.present, "pinned"
        self.wanted |= {"before"}

    def say_busy(self, what: str | None) -> None:
        """Say what is waited for, unless something is run, which is said all the time."""
        if self.task is None or self.task.done():
            self.widget.update(busy=what and {"what": what, "took": None})

    def _say_doing(self) -> None:
        self.widget.update(busy={"what": self.doing, "took": self.took.get(self.doing)})

    def _do_choose(self, content: dict[str, Any]) -> None:
        name, value = check_known(content.get("name"), _CHOICES, "choice", TryoutError), content.get("value")
        choose = act_of(self, name, "_choose_")
        if name in folderfiles.TEXT_KINDS:
            self._choose_text(name, str(value))
        elif choose is not None:
            choose(value)
        else:
            change: dict[str, Any] = {name: value}
            self._want(replace(self.wish, **change))

    def _choose_text(self, what: str, name: str) -> None:
        """Take another scenario or robot: one of the package, or a file of the folder."""
        if not name.endswith(".toml"):
            self._put_away(what)
            self._want(self._with(what, name, None))
            return
        self.folder.inside(name, ".toml")
        state = folderfiles.changed_at(self.folder, name)

        def take(file: FolderText) -> None:
            self._put_away(what)
            self.watched[what] = name, state
            self._want(self._with(what, name, file.text))

        self.read_then(what, name, take, folderfiles.read_text_file, self.folder, name)

    def _with(self, what: str, name: str, text: str | None) -> Any:
        """The wish with another scenario or robot."""
        if what == "scenario":
            return replace(self.wish, scenario=name, text=text, robot_of=0)
        return replace(self.wish, robot=name, robot_text=text, robot_of=self.wish.robot_of if name else 0)

    def _put_away(self, what: str) -> None:
        """Edit and watch the scenario or the robot no longer."""
        self.forget_file(what)
        self.desks.pop(what, None)
        if self.open == what:
            self.open = ""
        self._show_desk()

    def _choose_rival(self, value: Any) -> None:
        """Take another law to compare with; the folder's are looked at only now that they are asked for."""
        if isinstance(value, str) and (value.endswith(".fis") or ".py:" in value):
            file, ending = (value, ".fis") if value.endswith(".fis") else (value.rpartition(":")[0], ".py")
            self.folder.inside(file, ending)
            state = folderfiles.changed_at(self.folder, file)

            def take(found: Any) -> None:
                self.watched["rival"] = file, state
                self._set_rival(value, found)

            self.read_then("rival", file, take, *self._rival_reading(value))
            return
        if self.choices is None:
            raise TryoutError("the panel is not ready yet")
        known = [n for pairs in self.choices["rivals"].values() for n, _ in pairs]
        check_known(value, known, "law to compare with", TryoutError)
        self.forget_file("rival")
        self._set_rival(value, None)

    def _rival_reading(self, value: str) -> tuple[Any, ...]:
        """The function that reads a rival of the folder, and what it takes."""
        return (self.folder.read, value) if value.endswith(".fis") else (folderfiles.law_path, self.folder, value)

    def _set_rival(self, value: str, found: Any) -> None:
        """Compare with ``value``: with the law of the package, or what its file was ``found`` to hold."""
        self.rival, self.rival_found = value, found
        self.rounds.rows.pop("rival", None)
        self.wanted |= {"rival"}
        self.widget.update(trial=self._trial())

    def _choose_beside(self, value: Any) -> None:
        """Play the rival's run, too, beside that of the design."""
        if not isinstance(value, bool):
            raise TryoutError(f"beside must be true or false, got {value!r}")
        self.beside = value
        self.wanted |= {"rival"}
        self.widget.update(trial=self._trial())

    def _choose_count(self, value: Any) -> None:
        if isinstance(value, bool) or value not in COUNTS:
            raise TryoutError(f"the number of seeds is one of {', '.join(map(str, COUNTS))}; got {value!r}")
        before = self.rounds.shown(self.wish.seed)
        self.rounds.forget()
        self.rounds.count = value
        if self.rounds.shown(self.wish.seed) != before:
            self.wanted |= _RUNS
        self.widget.update(trial=self._trial(), seeds=None)
        self._settled_down()

    def _choose_shown(self, value: Any) -> None:
        """Draw and play another one of several seeds."""
        if isinstance(value, bool) or value not in self.rounds.seeds(self.wish.seed):
            raise TryoutError(f"there is no seed {value!r} among those that were run")
        self.rounds.picked = value
        self._publish("")

    def _choose_law(self, value: Any) -> None:
        """Take another of the laws that the system fits; a scenario that it does not drive gives way."""
        laws = {f"{law}/{task}": (law, task, kinds) for law, task, _, kinds in self.course.get("laws", [])}
        check_known(value, laws, "law", TryoutError)
        law, task, kinds = laws[value]
        wish = replace(self.wish, law=law, task=task)
        if self.course["kind"] not in kinds:
            self._put_away("scenario")
            wish = replace(wish, scenario="", text=None, robot_of=0)
            self.needs = None
        self._want(wish)

    def _do_file(self, content: dict[str, Any]) -> None:
        """Take the scenario file that was chosen on the page, from anywhere."""
        name, text = content.get("name"), content.get("text")
        if not isinstance(name, str) or not name.lower().endswith(".toml") or not isinstance(text, str):
            raise TryoutError("a scenario is a .toml file")
        name = name.replace("\\", "/").rpartition("/")[2][-100:]
        text = folderfiles.checked_text(name, text.encode("utf-8", "replace"))
        self._put_away("scenario")
        self._want(self._with("scenario", name, text))

    # Texts that are edited

    def _do_edit(self, content: dict[str, Any]) -> None:
        """Lay the chosen scenario or robot on the desk."""

        what = self._what(content)
        reading = self.reading.get(what)
        if reading is not None and not reading.done():  # what was chosen just now is edited
            reading.add_done_callback(lambda _: self.heard(content) if self.seen else None)
            return
        name, text = self._chosen_text(what)
        if not name:
            raise TryoutError("choose a robot first: what the scenario says of its robots is edited in the scenario")

        def lay(file: FolderText) -> None:
            self._turn_to(TextDesk(what, file, file.text, next(self.copies)))

        if what in self.desks:
            self._turn_to(self.desks[what])
        elif what in self.watched:
            file = self.watched[what][0]
            self.read_then(what, file, lay, folderfiles.read_text_file, self.folder, file)
        else:
            lay(FolderText(name, packaged_text(what, name) if text is None else text, None))

    def _chosen_text(self, what: str) -> tuple[str, str | None]:
        """The name of the scenario or the robot, and its text if it does not come with the package."""
        if what == "robot":
            return self.wish.robot, self.wish.robot_text
        shown = self.wish if self.wish.scenario or self.trial is None else self.trial
        return shown.scenario, shown.text

    def _what(self, content: dict[str, Any]) -> str:
        return check_known(content.get("what"), folderfiles.TEXT_KINDS, "text", TryoutError)

    def _desk(self, content: dict[str, Any]) -> TextDesk:
        what = self._what(content)
        if what not in self.desks:
            raise TryoutError(f"no {what} is being edited")
        return self.desks[what]

    def _do_text(self, content: dict[str, Any]) -> None:
        self._turn_to(self._desk(content).written(content.get("text")))

    def _do_revert(self, content: dict[str, Any]) -> None:
        self._lay(self._desk(content).reverted())
        self.wanted |= {"check"}

    def _do_save(self, content: dict[str, Any]) -> None:
        desk, name = self._desk(content), content.get("name")
        desk = desk.saved_as(self.folder, desk.file.name if name is None else str(name), bool(content.get("overwrite")))
        self._lay(desk)
        if not desk.asks:
            self.watch(desk.what, desk.file.name)
            if not desk.problem:
                self._want(self._with(desk.what, desk.file.name, desk.file.text))
            self.list_files({})

    def _turn_to(self, desk: TextDesk) -> None:
        """Show a desk, and check its text."""
        self.open = desk.what
        self.wanted |= {"check"}
        self._lay(desk)

    def _lay(self, desk: TextDesk) -> None:
        self.desks[desk.what] = desk
        self._show_desk()

    def _show_desk(self) -> None:
        desk = self.desks.get(self.open)
        self.widget.update(editor=None if desk is None else desk.shown())

    def _judge(self, fault: dict[str, Any], asked: TextDesk) -> None:
        """Say what is wrong with a text, or try it."""
        desk = self.desks.get(asked.what)
        if desk is None or desk.text != asked.text:
            return
        self._lay(desk.judged(fault))
        if not fault:
            name, text = self._chosen_text(desk.what)
            if text != desk.text and (text is not None or desk.edited):
                self._want(replace(self._with(desk.what, name, desk.text), robot_of=self.wish.robot_of))

    def _want(self, wish: Any) -> None:
        self.wish = wish
        self.wanted |= {"course", "tried"}

    def changed(self) -> Any:
        """Drive anew, unless nothing that drives was edited; the page waits a little for what comes of it."""
        if self.bench.document.judged != self.wish.terms:  # what was tuned counts by the same cost here
            self.rounds.forget()
            self.wanted |= _RUNS
            self._want(replace(self.wish, terms=self.bench.document.judged))
            self.go()
        if self.trial is not None and self.last and self.present == self.last[1] and "tried" not in self.wanted:
            return None  # one looks at another point, or edits what drives nobody
        if self.trial is None or _variables(self.present) != self.variables:
            self.wanted |= {"course"}
        self.wanted |= {"tried"}
        self.widget.update(seeds=None)
        self.go()
        return head_start(self.task)

    def reread(self, what: str, name: str) -> None:
        """Begin to read a file anew."""
        if what == "rival":
            self.begin_reading(what, self._reread_rival)
        else:
            self.read_then(what, name, partial(self._reread, what, name), folderfiles.read_text_file, self.folder, name)

    async def _reread_rival(self, mine: object) -> None:
        """Compare with the rival's file as it is now, or say that it cannot be."""
        rival, name = self.rival, self.watched["rival"][0]
        try:
            found = await self.bench.read(name, *self._rival_reading(rival))
        except (InputError, WorkError) as error:
            found = TryoutError(str(error))
        if self.reads["rival"] is mine:
            self._set_rival(rival, found)
            self.go()

    def _reread(self, what: str, name: str, file: FolderText) -> None:
        """Take a file as it is now; one that is being edited here stays as it is here."""
        if what in self.desks:
            self._lay(self.desks[what].reread(file))
            self.wanted |= {"check"}
            if self.desks[what].text != file.text:
                return
        self._want(replace(self._with(what, name, file.text), robot_of=self.wish.robot_of))

    def close(self) -> None:
        """Read and run no more."""
        super().close()
        self.rounds.rest()
        self.ruling.cancel()
        self.saying.cancel()

    # Runs

    def go(self) -> None:
        """Run what is wanted, if the panel is seen."""
        if self.seen and self.wanted:
            self.rounds.rest()
        if self.seen and self.wanted and (self.task is None or self.task.done()):
            self.task = asyncio.get_running_loop().create_task(self._run())

    async def _run(self) -> None:
        """Run what is wanted in the order of _ORDER, until nothing is left; an edit meanwhile makes it wanted again."""
        try:
            while self.seen and self.wanted:
                what = next(name for name in _ORDER if name in self.wanted)
                self.wanted -= {what}
                if what not in ("check", "rules"):
                    self.doing = what
                    self.saying.begin()
                asked, began = (self.wish, self._driven()), monotonic()
                try:
                    data = await self._made(what)
                    said = None
                except (InputError, WorkError) as error:
                    data, said = None, {"message": str(error), "failed": isinstance(error, WorkError)}
                if asked != (self.wish, self._driven()):
                    continue  # it belongs to another scenario: what is wanted now is run
                self.took[what] = monotonic() - began
                self._show(what, data, said)
        finally:
            self.saying.cancel()
            self.widget.update(busy=None)
        self._settled_down()

    def _settled_down(self) -> None:
        """Go on with several seeds, if nothing else is to be run."""
        if self.seen and not self.wanted and self.trial is not None:
            self.rounds.wake()

    def _show(self, what: str, data: dict[str, Any] | None, said: dict[str, Any] | None) -> None:
        if what == "course":
            self._settle(data, said)
        elif what in _RUNS:
            # That the law refuses the run is what became of it, and no fault of the page's.
            names = {"tried": self.present.name, "before": self.label, "rival": self._rival()}
            why = {"label": names[what], "why": said["message"], "failed": said["failed"]} if said else data
            self.widget.update(**{what: why} | ({"problem": None} if what == "tried" else {}))
            if what == "tried":
                self.ruling.begin()
        elif what in ("rules", "choices") and said is None:
            self.widget.update(**{what: data})

    def _want_rules(self) -> None:
        """Find which rule ruled when, once the design rests: a drag waits for what is drawn of its runs alone."""
        self.wanted |= {"rules"}
        self.go()

    def _settle(self, place: dict[str, Any] | None, said: dict[str, Any] | None) -> None:
        """Go on with the place that the system has found, or say why there is none."""
        if place is None:
            self.trial, self.course = None, {}
            self.wanted -= _RUNS
            self.rounds.forget()
            self.widget.update(trial=self._trial(), problem=said, **dict.fromkeys(("course", "seeds", *_RUNS)))
            return
        group = place["course"]["group"]
        if self.needs not in (None, group) and (self.wish.law or self.rival):
            self._forget_laws()
            return
        self.needs = group
        trial = TryoutTrial(**place["trial"])
        if trial != self.trial:
            self.wanted |= _RUNS
            self.rounds.forget()
            self.widget.update(seeds=None)
        self.trial, self.course = trial, place["course"]
        self.bench.pictured["trial"] = trial
        self.widget.update(trial=self._trial(), course=self.course, problem=None)

    def _forget_laws(self) -> None:
        """Find laws anew for a scenario of another group: one that is blind to obstacles was not chosen among them."""
        self.needs = None
        if "rival" not in self.watched:  # a file was chosen on purpose
            self.rival = ""
        self._want(replace(self.wish, law="", task=""))

    async def _made(self, what: str) -> dict[str, Any] | None:
        fis, trial = self.present, self._driven()
        keys = tuple(line.key for line in self.bench.document.design.lines if line.enabled)
        if what == "check":
            await self._check()
            return None
        if what == "choices":
            self.choices = await self.bench.background(tryout.choices)
            return self.choices
        if what == "course":
            self.variables = _variables(fis)
            return await self.bench.background(tryout.place_data, fis, self.wish, self.bench.document.path.stem)
        if trial is None:
            return None
        if what == "rules":
            moments, number = self.moments, self.moments.number
            if moments.asked is None or moments.system is None or self.course["played"]:
                return None  # of robots that are played the player's data say it
            return await self.bench.background(rule_times, moments.system, moments.asked) | {"number": number}
        if what == "tried":
            made = await self.bench.background(tryout.design_data, fis, trial)
            self.last = trial, fis, made
            return self.moments.take(fis, keys, made)
        if what == "before":
            if self.opening is not None:
                await self.opening
            label = {"label": self.label}
            if self.last[:2] == (trial, self.before):  # nothing has been edited yet
                return _beside(self.last[2]) | label
            return _beside(await self.bench.background(tryout.design_data, self.before, trial)) | label
        return await self._beside_rival(trial)

    async def _check(self) -> None:
        desk = self.desks.get(self.open)
        if desk is not None:
            fault = await self.bench.background(tryout.checked, desk.what, desk.file.name, desk.text, self.wish.folder)
            self._judge(fault, desk)

    async def _beside_rival(self, trial: TryoutTrial) -> dict[str, Any]:
        rival, file = self._rival(), self.watched.get("rival")
        key = (rival, file, trial, self.beside)
        if key not in self.known:
            made = await self.bench.background(tryout.rival_data, self._rival_law(), trial, rival)
            while len(self.known) >= _KEPT:
                del self.known[next(iter(self.known))]
            self.known[key] = made if self.beside else _beside(made)
        return self.known[key]

    def _rival_law(self) -> Sugeno | str:
        """The rival: a system, or as robotics.laws.catalogue.make_controller takes it.

        Raises InputError where its file has none.
        """
        rival, found = self._rival(), self.rival_found
        if isinstance(found, InputError):
            raise found
        return found if found is not None and rival == self.rival else rival

    # Several seeds

    def _driven(self) -> TryoutTrial | None:
        """The trial with the seed that is drawn and played."""
        return None if self.trial is None else replace(self.trial, seed=self.rounds.shown(self.trial.seed))

    def _work(self) -> dict[str, Work]:
        trial, fis = self.trial, self.present
        if trial is None:
            return {}
        work: dict[str, Work] = {"tried": (trial.seed, severalseeds.design_seeds, fis, trial, self.rounds.count)}
        if self.weighed == fis:
            for name, other in severalseeds.without_rules(fis).items():
                work[name] = (trial.seed, severalseeds.rival_seeds, other, trial, "")
        if self.before != fis:
            work["before"] = (trial.seed, severalseeds.rival_seeds, self.before, trial, "")
        rival = self._rival()
        with suppress(InputError):  # the file is gone: what is shown of the rival says so
            if (law := self._rival_law()) != "":
                work["rival"] = (trial.seed, severalseeds.rival_seeds, law, trial, rival)
        return work

    def _progress(self) -> None:
        done, trial = self.rounds.done, self.trial
        of = len(self._work()) * self.rounds.count if trial is not None and done is not None else 0
        self.widget.update(round=None if done is None else {"done": done, "of": of})

    def _publish(self, name: str) -> None:
        """Show what is known of several seeds; the worst of the design's is drawn, unless one was picked by hand."""
        trial, known = self.trial, self.rounds.known()
        rows = known.get("tried")
        if trial is None or rows is None:
            return
        metrics, by = self.course["metrics"], severalseeds.RANKED_BY[self.course["kind"]]
        if name in ("", "tried"):
            self.rounds.worst = severalseeds.worst_seed(rows, by)
            if not self.last or self.last[0] != self._driven():
                self.wanted |= _RUNS
        runs, state = {"tried": severalseeds.summary(rows, metrics)}, severalseeds.state_of
        for other in ("before", "rival"):
            others = rows if other == "before" and self.before == self.present else known.get(other)
            if others is not None:
                runs[other] = severalseeds.summary(others, metrics)
        without = {name: each for name, each in known.items() if name.startswith("without ")}
        weighed = {name: severalseeds.summary(each, metrics) for name, each in without.items()}
        ranked = next((m for m in metrics if m["name"] == by), None)
        self.widget.update(
            seeds={
                "worth": severalseeds.rules_worth(self.present, runs["tried"], weighed, ranked),
                "count": self.rounds.count,
                "shown": self.rounds.shown(trial.seed),
                "worst": self.rounds.worst,
                "by": next((m["title"] for m in metrics if m["name"] == by), ""),
                "runs": runs,
                "rows": [{"state": state(row), "value": row.get("metrics", {}).get(by)} | row for row in rows],
            }
        )
        self.go()

    # What the page sees

    def _trial(self) -> dict[str, Any]:
        """The choices as the page shows them, without the text of a file."""
        shown = asdict(self.trial or self.wish) | {"rival": self._rival(), "kind": self.course.get("kind", "")}
        shown |= {"count": self.rounds.count, "beside": self.beside}
        return {name: value for name, value in shown.items() if name not in _HIDDEN}

    def _rival(self) -> str:
        """The law to compare with: the one that was chosen, if it drives such scenarios; a file's need not say so."""
        if "rival" in self.watched:
            return self.rival
        kind = self.course.get("kind", "")
        if self.rival and self.rival in [name for name, _ in (self.choices or {"rivals": {}})["rivals"].get(kind, [])]:
            return self.rival
        return str(self.course.get("rival", ""))


def _system_in(path: Path) -> Sugeno:
    check_size(path, path.name)
    return read_fis(path)


def _beside(made: dict[str, Any]) -> dict[str, Any]:
    """What is shown of a run beside that of the design, which alone is played; the player's data may be a megabyte."""
    return {name: value for name, value in made.items() if name not in ("player", "asked", "reference")}


def _variables(fis: Sugeno) -> tuple[Any, ...]:
    """What a system's place depends on."""
    return fis.name, [v.name for v in fis.inputs], [v.name for v in fis.outputs]
