# Two set-up commands: `make demo` and `make test`. The logic is in scripts/.
CARGO ?= cargo

.PHONY: demo test check bench setup

demo: setup
	scripts/demo.sh

test: setup
	$(CARGO) test --workspace --release

check: setup
	scripts/check.sh

bench: setup
	scripts/bench.sh

setup:
	scripts/setup.sh
