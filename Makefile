# Everything a checkout needs; all of it stays inside the checkout (.venv, out).
#   make setup      virtual environment with the pinned packages
#   make demo       learn, grasp the tall glass, write video, contact sheet and result to out/demo
#   make test       the tests, slow ones sampled
#   make test-ci    the slow ones that nothing may land without
#   make pythons    the quick tests with each Python from 3.11 to 3.13 that is found here
#   make mutants    whether the tests notice small faults in what decides verdicts
#   make docs       the documentation, to out/docs/index.html, without dead links
#   make screenshots  its pictures of the live page, the report and itself, in headless Chromium
PYTHON ?= python3
BIN := .venv/bin
DEMO := out/demo
TASK := tall-glass-drink
PICTURE := cup-side-move

.PHONY: setup demo test test-ci test-all pythons mutants coverage check docs screenshots notebooks bench build clean lock models assets pictures rendering results
.DELETE_ON_ERROR:

setup: .venv/.installed

.venv/.installed: requirements.lock pyproject.toml
	$(PYTHON) -m venv .venv
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-cache-dir --require-hashes -r requirements.lock
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-cache-dir --no-deps --no-build-isolation --editable .
	touch $@

# A machine on which neither EGL nor OSMesa renders gets OSMesa, or EGL where there is no OSMesa any
# longer (Mesa 25.1), if this may install it; elsewhere the check has named the command already.
rendering: setup
	@$(BIN)/handsim doctor --rendering-only || { \
	  if [ "$$(id -u)" = 0 ] && command -v apt-get >/dev/null; then \
	    apt-get update -qq; \
	    apt-get install -y -qq libosmesa6 || apt-get install -y -qq libegl1 libgl1-mesa-dri libopengl0; \
	    $(BIN)/handsim doctor --rendering-only; \
	  else exit 1; fi; }

demo: rendering
	mkdir -p $(DEMO)
	$(BIN)/handsim learn -o $(DEMO)/controller.npz
	$(BIN)/handsim grasp $(DEMO)/controller.npz --task $(TASK) --require-success -o $(DEMO) --json > $(DEMO)/result.json
	$(BIN)/handsim render $(DEMO)/$(TASK).npz -o $(DEMO)/grasp.mp4
	$(BIN)/handsim render $(DEMO)/$(TASK).npz -o $(DEMO)/postures.png
	@echo "Look at $(DEMO)/grasp.mp4 and $(DEMO)/postures.png; the outcome is in $(DEMO)/result.json"

# One process a core; more BLAS threads than cores would only wait for each other.
PYTEST := OPENBLAS_NUM_THREADS=$${OPENBLAS_NUM_THREADS:-1} $(BIN)/python -m pytest \
  --numprocesses auto --maxprocesses 8 --benchmark-disable --nbmake

test: setup
	$(PYTEST) -m "not slow" tests notebooks

# One after the other, since some of them measure time.
test-ci: setup
	$(BIN)/python -m pytest -m ci --benchmark-disable tests

test-all: setup
	$(PYTEST) tests notebooks

pythons: setup
	$(BIN)/python tests/packaging/pythons.py

mutants: setup
	$(BIN)/python tests/mutants/run.py

# Each process measures its own lines (pyproject.toml); here they are put together. The one test
# that counts bytes would count those of the measurement.
coverage: setup
	mkdir -p out
	$(BIN)/python -m coverage erase
	OPENBLAS_NUM_THREADS=$${OPENBLAS_NUM_THREADS:-1} $(BIN)/python -m coverage run -m pytest \
	  --numprocesses auto --maxprocesses 8 --benchmark-disable -m "not slow" tests \
	  --deselect tests/navigation/test_function.py::test_an_evaluator_makes_no_arrays
	$(BIN)/python -m coverage combine --quiet
	$(BIN)/python -m coverage report

check: setup
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/lint-imports
	$(BIN)/pyright

# All pages are read again, since modules may have gone; notebooks only where they have changed. Pages
# of sources are kept by Sphinx where the source has not changed, though what links there has.
docs: rendering
	rm -rf out/docs/_modules
	MUJOCO_GL=$$($(BIN)/python -c "from handsim.viewing.opengl.backend import choose_backend as f; print(f())") \
	$(BIN)/sphinx-build -W -E --keep-going -j auto docs out/docs
	$(BIN)/python docs/_ext/dead_links.py out/docs

# Of the documentation as it was built last.
screenshots: rendering
	$(BIN)/python -m tests.viewing.screenshots docs/pictures

notebooks: setup
	$(BIN)/python -m pytest --nbmake notebooks

bench: rendering
	mkdir -p out
	MUJOCO_GL=$$($(BIN)/python -c "from handsim.viewing.opengl.backend import choose_backend as f; print(f())") \
	$(BIN)/python -m pytest tests/benchmarks -m slow --benchmark-only --benchmark-json=out/benchmarks.json

results: setup
	mkdir -p out
	$(BIN)/python -m tests.benchmarks.human_grasps demonstrator built-in -o out/results.csv
	$(BIN)/python tests/benchmarks/grasp_replay.py

build: setup
	rm -rf dist
	$(BIN)/python -m hatchling build

clean:
	rm -rf .venv out dist .pytest_cache .ruff_cache .hypothesis .import_linter_cache .benchmarks

# The lines below regenerate what is committed. Plans are searched beginning with those committed, as
# for any other controller.
lock: setup
	$(BIN)/python -m pip install --quiet uv
	$(BIN)/uv pip compile --quiet --upgrade --universal --python-version 3.11 --generate-hashes \
	  --no-emit-index-url --custom-compile-command "make lock" --extra dev pyproject.toml -o requirements.lock

models: setup
	$(BIN)/python models/hand/make.py
	$(BIN)/python models/arm/make.py

assets: setup
	$(BIN)/python assets/objects/make.py
	$(BIN)/python assets/make_experiments.py
	mkdir -p out
	$(BIN)/handsim learn -o out/built-in.npz
	$(BIN)/handsim grasp out/built-in.npz --task all --jobs 2
	cp out/built-in.npz assets/controller.npz
	rm -f assets/plans/*.json
	cp out/built-in.plans/*.json assets/plans/
	$(BIN)/handsim baseline record assets/baseline.npz

pictures: rendering
	$(BIN)/python -m handsim.viewing.contact_sheets keyframes models/hand/hand.png
	$(BIN)/python -m handsim.viewing.contact_sheets hands models/hand/sizes.png
	$(BIN)/python -m handsim.viewing.contact_sheets arm models/arm/arm.png
	$(BIN)/python -m handsim.viewing.contact_sheets retargeting models/hand/retargeting.png \
	  --robot tests/retargeting/data/four_finger_hand.xml --palm base_frame \
	  --fingertips thumb=thumb_touch index=f1_touch middle=f2_touch ring=f3_touch
	$(BIN)/python -m handsim.viewing.contact_sheets grasps assets/grasps.png
	MUJOCO_GL=$${MUJOCO_GL:-egl} $(BIN)/python assets/objects/sheet.py assets/objects.png
	$(BIN)/handsim grasp --task $(PICTURE) -o out
	$(BIN)/handsim render out/$(PICTURE).npz -o assets/pictures/grasp.gif --plain --shadows \
	  --size 400x300 --fps 10
	$(BIN)/handsim figures -o out/figures
	cp out/figures/fig6_paths.png assets/pictures/paths.png
