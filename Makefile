# `make` prints what there is. Everything works in a fresh clone; nothing is installed on the machine.

# How many times as long `make prove` goes as `make test`.
BLADEPLAN_ROUNDS ?= 20

.DEFAULT_GOAL := help
.PHONY: help demo serve test prove bench lint openapi linuxcnc vim

help: ## Print this list
	@sed -n 's/^\([a-z-]*\):[^#]*## \(.*\)/\1|\2/p' $(MAKEFILE_LIST) | \
		while IFS='|' read -r target says; do printf '  make %-9s %s\n' "$$target" "$$says"; done

demo: ## Post the example ply as an MES would, fetch its program, replay it; all of it in demo-out/
	cargo build --release --locked --package bladeplan --package bladeplan-demo --bins
	target/release/bladeplan-demo

serve: ## Run the service on 127.0.0.1:8080 with ./bladeplan.db
	cargo run --release --locked -- serve

test: lint linuxcnc vim ## Lints, then all tests
	cargo test --locked

prove: linuxcnc vim ## All tests, the random ones BLADEPLAN_ROUNDS (20) times as long
	BLADEPLAN_ROUNDS=$(BLADEPLAN_ROUNDS) PROPTEST_CASES=$$((256 * $(BLADEPLAN_ROUNDS))) cargo test --locked --profile prove

bench: ## Measure the stages of planning
	cargo bench --locked

lint: ## Formatting and clippy, warnings as errors
	cargo fmt --all --check
	cargo clippy --locked --workspace --all-targets -- -D warnings

openapi: ## Write openapi/v1.json anew from the code
	mkdir -p openapi
	cargo run --release --locked --quiet -- openapi > openapi/v1.json.part
	mv openapi/v1.json.part openapi/v1.json

linuxcnc: ## Put LinuxCNC's interpreter under target/linuxcnc, for the tests
	tests/linuxcnc/prepare

vim: ## Put Vim and its syntax of KRL under target/vim, for the tests
	tests/vim/prepare
