"""The designer's panel "Try it": the rule base that is edited drives a robot, anew after every edit.

:class:`robotics.designer.session.TryoutSession` does the work. The module also generates data for the panel "Train".
"""

from collections.abc import Sequence
from functools import partial
from typing import Any


class TryItPanel:
    """The panel "Try it", as the designer finds it."""

    title = "Try it"
    order = 50

    def build(self, bench: Any) -> None:
        """Put the panel on the page of ``bench``, a fuzzy.designer.panel.Workbench."""
        from robotics.designer.session import TryoutSession

        TryoutSession(bench)


panel = TryItPanel()


# Data for the panel "Train" -------------------------------------------------------------------------------------


def formation_data() -> Sequence[Any]:
    """The formation data of thesis 5.2.1 as anfis.designer.task.Generator; an entry point of the panel "Train"."""
    from anfis.designer.task import Generator

    return [
        Generator("formation-literal", "Formation data, as the thesis describes them", partial(_formation, "literal")),
        Generator("formation-well-posed", "Formation data, well-posed", partial(_formation, "well-posed")),
    ]


def _formation(kind: str) -> Any:
    from anfis.designer.task import Columns
    from robotics.experiments.learning.formationdata import FILES
    from robotics.experiments.learning.formationdata import formation_data as made

    table = made(FILES[f"formation-{kind}.csv"])
    return Columns(f"formation data, {kind}", table.names, table.values, table.inputs)
