# Two set-up commands: `make demo` and `make test`. The logic is in scripts/.
CARGO ?= cargo

.PHONY: demo test check doc bench setup

demo: setup
	scripts/demo.sh

test: setup
	$(CARGO) test --workspace --release

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
