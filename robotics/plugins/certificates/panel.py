"""The designer's panel "Certificate": what is proven of the closed loop of the rule base, anew after every edit."""

from typing import Any

from fuzzy.plugins.designer.panel import SessionPanel


def _begin(bench: Any) -> None:
    from robotics.plugins.certificates.session import CertificateSession

    CertificateSession(bench)


panel = SessionPanel("Certificate", 60, _begin, purpose="robot")
