# Two set-up commands: `make demo` and `make test`. The logic is in scripts/.
CARGO ?= cargo

# Not the Python package, which has its own tests (scripts/python.sh), nor the benchmark that needs criterion.
tested = --workspace --exclude tsc-family-python --exclude tsc-family-benches

.PHONY: demo test check doc bench setup

demo: setup
	scripts/demo.sh

test: setup
	$(CARGO) test $(tested) --release

check: setup
	scripts/check.sh

# The documentation of this project alone: with that of its 200 dependencies it takes minutes. In release, so
# that it shares what building has compiled.
doc: setup
	RUSTDOCFLAGS="-D warnings" $(CARGO) doc --workspace --no-deps --release

bench: setup
	scripts/bench.sh

setup:
	scripts/setup.sh
