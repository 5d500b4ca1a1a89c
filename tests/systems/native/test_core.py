"""The C core: each of its files calls only those before it."""

import re

from ropeway.systems.native.core import SOURCES, core_files


def test_each_file_calls_only_those_before_it() -> None:
    files = core_files()
    header = files["ropeway.h"]
    declared = {
        name: set(re.findall(r"\b(rw_\w+)\(", header.split(f"/* {name} */")[1].split("\n\n")[0])) for name in SOURCES
    }
    assert all(declared.values())
    below: set[str] = set()
    for name in SOURCES:
        below |= declared[name]
        called = set(re.findall(r"\b(rw_\w+)\(", files[name])) & set().union(*declared.values())
        assert called <= below, name


def test_functions_of_the_core_are_declared_where_they_are_defined() -> None:
    files = core_files()
    for name in SOURCES:
        defined = set(re.findall(r"^(?!static)[\w ]+ \*?(rw_\w+)\([^;{]*\)\n\{", files[name], re.MULTILINE))
        assert defined == set(
            re.findall(r"\b(rw_\w+)\(", files["ropeway.h"].split(f"/* {name} */")[1].split("\n\n")[0])
        )
