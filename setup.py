"""Where the packages of ``steadyload`` lie: every top-level folder is installed below one name."""

import atexit
import shutil
import tempfile

from setuptools import find_packages, setup

FOLDERS = {
    "steadyload": "harness",
    "steadyload.engines": "engines",
    "steadyload.learners": "learners",
    "steadyload.reports": "reports",
}

BUILD = tempfile.mkdtemp(prefix="steadyload-build-")
atexit.register(shutil.rmtree, BUILD, ignore_errors=True)

setup(
    packages=[
        ".".join([name, *inner])
        for name, folder in FOLDERS.items()
        for inner in ([], *([package] for package in find_packages(folder)))
    ],
    package_dir=FOLDERS,
    package_data={"": ["**/*"]},
    exclude_package_data={
        "": ["__pycache__/*", "*/__pycache__/*"],
        "steadyload.reports": ["published/**", "rows/**"],
    },
    # What an earlier build left beside the sources would add modules that have been deleted since.
    options={"build": {"build_base": BUILD}, "egg_info": {"egg_base": BUILD}},
)
