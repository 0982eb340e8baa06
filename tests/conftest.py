"""Tests stay on this host and in a ROS domain of their own, however they are started; none compares values that hold NaN by ==."""

import os
import random
import sys

from evodevo_sim.ros.process import stay_on_this_host
from hypothesis import settings
from values import guard, value_classes

settings.register_profile("busy machine", deadline=None)  # how long an example takes says nothing
settings.load_profile("busy machine")
stay_on_this_host()
_DOMAINS = 200  # of those that Fast DDS has ports for
_chosen = int(os.environ.setdefault("ROS_DOMAIN_ID", str(random.randint(1, 100))))
_worker = int(os.environ.get("PYTEST_XDIST_WORKER", "gw0").removeprefix("gw"))
os.environ["ROS_DOMAIN_ID"] = str((_chosen - 1 + 67 * _worker) % _DOMAINS + 1)  # one for each process that runs tests


_loaded = 0  # modules, when last looked


def pytest_runtest_setup():
    global _loaded  # noqa: PLW0603  (hooks of pytest have no object of their own)
    if len(sys.modules) != _loaded:
        _loaded = len(sys.modules)
        for cls in value_classes():
            guard(cls)
