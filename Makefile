# evodevo: `make` says what there is.  Every target sets up what is missing first.

.DEFAULT_GOAL := help
.PHONY: help setup build evolve lint test bench peers replay lock clean
MAKEFLAGS += --no-print-directory

in_environment := scripts/run.sh

help:
	@echo 'make setup                        install and build what is missing; PYTHON=... chooses the interpreter'
	@echo 'make evolve [ARGS="..."]          evolve: ros2 run evodevo_ga evolve ARGS'
	@echo 'make replay [ARGS="..."]          show a recording: ros2 run evodevo_sim replay ARGS'
	@echo 'make test [ARGS="..."]            run the tests, two files at a time: pytest tests ARGS'
	@echo 'make lint                         check the code by ruff and mypy, as the tests do too'
	@echo 'make bench [ARGS="..."]           measure: benchmarks/run.py ARGS; ARGS=--quick for a look'
	@echo 'make peers                        install the other engines that `make bench` compares with'
	@echo 'make lock                         pin requirements.in in requirements.lock'
	@echo 'make clean                        remove everything that set-up made'

setup build:
	@scripts/setup.sh

evolve: setup
	@$(in_environment) ros2 run evodevo_ga evolve $(ARGS)
	@echo "(in this directory: make replay, or source scripts/env.sh first to have ros2 in your shell)"

replay: setup
	@$(in_environment) ros2 run evodevo_sim replay $(ARGS)

lint: setup
	@$(in_environment) scripts/lint.sh

# Each run has ROS domains of its own, one for each of the two processes that share the files.
test: setup
	@ROS_DOMAIN_ID=$${ROS_DOMAIN_ID:-$$(shuf -i 1-100 -n 1)} $(in_environment) python -m pytest tests -n 2 --dist loadfile $(ARGS)

bench: setup
	@$(in_environment) python benchmarks/run.py $(ARGS)

peers: setup
	@scripts/peers.sh

lock:
	@scripts/lock.sh

clean:
	rm -rf .venv setup.log ros_ws/build ros_ws/install ros_ws/log
