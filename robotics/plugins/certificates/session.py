"""The panel "Certificate" of one page: what is proven of the rule base that is edited, anew after every edit."""

from dataclasses import asdict
from pathlib import Path
from typing import Any

from fuzzy.naming import check_known
from fuzzy.plugins.designer.latest import Latest
from fuzzy.plugins.designer.session import PanelSession
from fuzzy.system import Sugeno
from robotics.plugins.certificates.badge import drawn
from robotics.plugins.certificates.certificate import CertificateError
from robotics.plugins.certificates.loopmodel import LoopModel
from robotics.simulation.scenario.robots import robot_names

_MODULE = Path(__file__).parent / "static" / "certificate.js"
_BEGUN = LoopModel(speed_low=0.2, curvature=0.5)  # what can be proven within seconds, while one edits


class CertificateSession(PanelSession):
    """The certificate of one page: what is assumed, and what came of it."""

    error = CertificateError

    def __init__(self, bench: Any) -> None:
        super().__init__(bench, robot="etsro", **asdict(_BEGUN))
        self.proofs = Latest(self._prove)
        self.shown: Sugeno | None = None  # the system that is certified
        self.put(_MODULE, choice=self.choice, robots=robot_names(), answer=None, works=True)
        self.changed()

    def _do_choose(self, message: dict[str, Any]) -> None:
        name, value = self.setting(message)
        if name == "robot":
            check_known(value, robot_names(), "robot", CertificateError)
        elif isinstance(value, bool) or not isinstance(value, int | float):
            raise CertificateError(f"{name} must be a number").about(name)
        chosen = {**self.choice, name: value}
        _model(chosen)
        self.choice = chosen
        self.prove()

    def changed(self) -> None:
        """Prove anew, unless only another point is looked at."""
        if self.shown != self.present:
            self.prove()

    def prove(self) -> None:
        """Look for a certificate; what is asked for meanwhile comes after it, once."""
        self.shown = self.present
        self.widget.update(choice=self.choice, works=True)
        self.proofs.wish()

    async def _prove(self) -> None:
        if self.bench.closed:
            return
        asked, answer = (self.shown, self.choice), None
        with self.refusing({}):
            answer = await self.bench.background(drawn, self.shown, self.choice["robot"], _model(self.choice))
        if asked == (self.shown, self.choice):
            self.widget.update(answer=answer, works=False)

    def close(self) -> None:
        """Prove no more."""
        if self.proofs.task is not None:
            self.proofs.task.cancel()


def _model(choice: dict[str, Any]) -> LoopModel:
    """The assumptions that are chosen. Raises CertificateError."""
    return LoopModel(**{name: value for name, value in choice.items() if name != "robot"})
