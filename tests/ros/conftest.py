"""ROS for the tests: on this machine alone, and in a domain of its own for each worker."""

import os
import sys
import warnings
from pathlib import Path

import pytest

PACKAGE = Path(__file__).parent.parent.parent / "ros"
sys.path.insert(0, str(PACKAGE))
os.environ["PYTHONPATH"] = os.pathsep.join(filter(None, [str(PACKAGE), os.environ.get("PYTHONPATH", "")]))
os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"  # since Iron;
os.environ["ROS_LOCALHOST_ONLY"] = "1" if os.environ.get("ROS_DISTRO") == "humble" else "0"  # before it
os.environ["ROS_DOMAIN_ID"] = str(1 + os.getpid() % 100)


@pytest.fixture(scope="session")
def ros(tmp_path_factory):
    """rclpy, initialised; a test that asks for it is skipped where there is none."""
    rclpy = pytest.importorskip("rclpy", reason="rclpy is not installed: pip install '.[ros]'")
    os.environ["ROS_LOG_DIR"] = str(tmp_path_factory.mktemp("ros"))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # its parser of message definitions imports what is deprecated
        pytest.importorskip("rosidl_generator_py", reason="rclpy is there, and its messages are not")
    rclpy.init()
    yield rclpy
    rclpy.shutdown()
