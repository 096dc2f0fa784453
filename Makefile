# Two set-up commands: `make demo` and `make test`. The logic is in scripts/. `make nightly` is for maintainers,
# before a release.
CARGO ?= cargo

.PHONY: demo test check doc bench nightly setup

demo: setup
	scripts/demo.sh

# With the profile, folder and features of `make demo`, so that nothing is compiled twice. Many tests wait for programs
# that they start, so there are twice as many at a time as processors.
test: setup
	RUST_TEST_THREADS=$${RUST_TEST_THREADS:-$$((2 * $$(nproc)))} $(CARGO) test --profile quick

check: setup
	scripts/check.sh
	$(MAKE) doc

# The documentation of this project alone: with that of its 200 dependencies it takes minutes. In the
# profile of the tests, so that it shares what they have compiled.
doc: setup
	RUSTDOCFLAGS="-D warnings" $(CARGO) doc --workspace --no-deps --profile quick

bench: setup
	scripts/bench.sh

nightly: setup
	scripts/nightly.sh

setup:
	scripts/setup.sh
