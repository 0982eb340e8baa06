"""Tests stay on this host and in a ROS domain of their own, however they are started."""

import os
import random

from evodevo_sim.ros.process import stay_on_this_host

stay_on_this_host()
os.environ.setdefault("ROS_DOMAIN_ID", str(random.randint(1, 100)))
