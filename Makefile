# medkit: `make book` and `make test` are all a newcomer needs; both set up .venv first.
PYTHON ?= $(shell command -v python3.11 || command -v python3)
VENV   := .venv
BIN    := $(VENV)/bin
READY  := $(VENV)/.ready
JOBS   ?= 2
export PYTHONHASHSEED := 0
export OMP_NUM_THREADS := 1
export OPENBLAS_NUM_THREADS := 1
export NUMBA_NUM_THREADS := 1

.PHONY: help book test lab labs lint browser bench clean lock notebooks
help:
	@echo "make book      rebuild every notebook into HTML under build/book"
	@echo "make test      everything CI checks: style, types, import direction, tests, notebooks"
	@echo "make lab       open JupyterLab at the first chapter"
	@echo "make lint      style, types and import direction alone"
	@echo "make bench     the benchmarks, rivals in the same run"
	@echo "make notebooks execute every notebook in place, so that its outputs are stored anew"
	@echo "make browser   run every notebook in JupyterLab in Chromium and look at it"
	@echo "make labs      write the students' copies of the labs to build/labs"
	@echo "make lock      resolve the dependencies anew into requirements.lock (needs uv)"
	@echo "make clean     remove what was built, the environment included"

$(READY): requirements.lock pyproject.toml tools/make_environment.sh
	bash tools/make_environment.sh "$(PYTHON)" "$(VENV)"
	@touch $@

book: $(READY)
	$(BIN)/python -m medkit.book build --out build/book --jobs $(JOBS)

test: lint
	$(BIN)/python -m pytest -n $(JOBS) --dist worksteal --doctest-modules medkit tests
	$(BIN)/python -m pytest -n $(JOBS) --dist loadfile -p no:doctest --nbval --nbval-cell-timeout 150 --nbval-sanitize-with tests/nbval_sanitize.cfg notebooks

lab: $(READY)
	$(BIN)/jupyter lab notebooks/00_start_here.ipynb

lint: $(READY)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy medkit
	$(BIN)/lint-imports

browser: $(READY)
	$(BIN)/python -c "import playwright" 2>/dev/null || { echo "make browser needs Chromium and the extra 'browser': pip install playwright pillow" >&2; exit 2; }
	$(BIN)/python tools/browser_check.py

labs: $(READY)
	$(BIN)/python -m medkit.labs students --out build/labs

bench: $(READY)
	$(BIN)/python -m benchmarks

notebooks: $(READY)
	$(BIN)/python -m medkit.book execute --jobs $(JOBS)

lock:
	uv pip compile --quiet --universal --python-version 3.11 --no-header --no-emit-index-url \
	  --no-emit-find-links --generate-hashes --extra book --extra cluster --extra recordings --extra test \
	  pyproject.toml -o requirements.lock

clean:
	rm -rf build $(VENV) .pytest_cache .mypy_cache .ruff_cache .hypothesis *.egg-info
