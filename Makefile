PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
PACKAGES := oblique_impact fem_beam modal renders validation

.PHONY: install demo test test-slow test-pythons lint bounds docs pictures notebook package findings bench clean

install: $(VENV)/.installed

# compiles the modules as pip does with what it copies: else an environment that keeps no bytecode parses all of them at
# every start
$(VENV)/.installed: requirements.lock pyproject.toml
	@echo "installing what it needs into $(VENV): one to three minutes"
	$(PYTHON) -m venv $(VENV)
	$(BIN)/pip install --quiet --disable-pip-version-check -r requirements.lock
	$(BIN)/pip install --quiet --disable-pip-version-check --no-deps --no-build-isolation -e .
	$(BIN)/python -m compileall -q $(PACKAGES)
	touch $@

demo: install
	$(BIN)/python examples/paper_demo.py out/demo

test: install
	@echo "the tests: about nine minutes on two cores"
	$(BIN)/python -m pytest -n 2 --dist loadfile -m "not slow"

test-slow: install
	@echo "the slow tests: half an hour or more"
	$(BIN)/python -m pytest -n 2 -m slow

# the suite on every supported Python that is there; PYTHONS="..." names others or gives their paths
PYTHONS ?= python3.11 python3.12 python3.13

test-pythons:
	@set -e; for python in $(PYTHONS); do \
		if $$python -c pass 2>/dev/null; then \
			echo "== $$python"; \
			$(MAKE) --no-print-directory test PYTHON=$$python VENV=.venv-$$($$python -c "import sys; print(\"%d.%d\" % sys.version_info[:2])"); \
		else echo "== $$python: not there"; fi; \
	done

# mypy does not read setuptools' package-dir: it is shown the tree as it is installed
lint: install
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	rm -rf build/tree && mkdir -p build/tree/oblique_impact
	ln -s $(CURDIR)/oblique_impact/* $(addprefix $(CURDIR)/,fem_beam modal renders validation) build/tree/oblique_impact
	$(BIN)/mypy

docs: install
	@echo "the documentation: 2 to 6 minutes"
	$(BIN)/python -m sphinx -b html -W --keep-going -n docs docs/_build/html
	@echo "documentation: docs/_build/html/index.html"

# the pictures of the pages that are kept with them
pictures: install
	$(BIN)/python -m docs.pictures.draw

# the tutorial's notebook, from its program
notebook: install
	$(BIN)/python -m docs.notebook

# the program with every dependency at its lower bound, in an environment that is gone afterwards
bounds:
	.ci/bounds

# wheel and source distribution, each installed and used outside of the checkout
package: install
	$(BIN)/python .ci/package

# what libraries and formats did when it was written down, each in an environment that is gone afterwards; needs network
findings:
	@result=0; for script in findings/*.sh; do \
		begin=$$(date +%s); word=ok; \
		if ! said=$$(bash $$script 2>&1); then \
			result=1; case "$$said" in *AssertionError*) word=changed;; *) word=failed;; esac; \
		fi; \
		printf '%-32s %-8s %4d s\n' $$(basename $$script .sh) $$word $$(($$(date +%s) - begin)); \
		[ $$word = ok ] || printf '%s\n' "$$said" | tail -n 3; \
	done; exit $$result

bench: install
	$(BIN)/python benchmarks/bench.py

clean:
	rm -rf $(VENV) out build docs/_build docs/gallery examples/*.png examples/*.svg examples/measured/*.svg examples/*.gif *.egg-info
