import doctest
import subprocess
import sys

import pytest

import handsim


def test_there_are_public_names():
    assert len(handsim.__all__) > 20


@pytest.mark.parametrize("name", handsim.__all__)
def test_every_public_name_is_there(name):
    assert getattr(handsim, name) is not None


def test_unknown_names_are_attribute_errors():
    with pytest.raises(AttributeError, match="nothing"):
        _ = handsim.nothing


def test_the_examples_of_the_package_run():
    results = doctest.testmod(handsim)
    assert results.attempted >= 5
    assert results.failed == 0


def test_importing_the_package_imports_nothing_heavy():
    code = (
        "import sys, handsim; "
        "heavy = {'mujoco', 'sklearn', 'scipy', 'matplotlib'} & set(sys.modules); "
        "sys.exit(','.join(heavy) or 0)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def test_help_imports_nothing_heavy():
    """It is what a user sees first: numpy takes a tenth of a second, rich two."""
    code = (
        "import sys, contextlib\n"
        "sys.argv = ['handsim', '--help']\n"
        "from handsim.cli import main\n"
        "with contextlib.suppress(SystemExit):\n"
        "    main()\n"
        "heavy = {'numpy', 'mujoco', 'sklearn', 'scipy', 'matplotlib', 'rich'} & set(sys.modules)\n"
        "sys.exit(','.join(heavy) or 0)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert "recordings" in done.stdout
