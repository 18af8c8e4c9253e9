# SPDX-License-Identifier: BSD-3-Clause
"""The Python blocks of every page run, and print what the page shows."""

import pytest

from tests.docs import snippets
from tests.docs.snippets import PAGES, ROOT, Block, agrees, blocks, printed

WITH_CODE = [page for page in PAGES if blocks((ROOT / page).read_text(encoding="utf-8"))]


@pytest.mark.page
@pytest.mark.parametrize("page", WITH_CODE)
def test_snippets_run_and_print_what_is_shown(page, tmp_path):
    found = blocks((ROOT / page).read_text(encoding="utf-8"))
    for block, output in zip(found, printed(found, tmp_path), strict=True):
        if block.shown is not None:
            assert agrees(block.shown, output), f"{block.code}\nprints\n{output}"
        else:
            assert not output.strip(), f"{block.code}\nprints what the page does not show:\n{output}"


def test_pages_are_found():
    assert {"README.md", "docs/tutorial/disk.md", "docs/howto/machine_code.md", "docs/theory/energy.md"} <= set(
        WITH_CODE
    )


def test_a_page_that_is_wrong_is_noticed(tmp_path):
    text = "```python\nprint(1)\n```\n```text\n2\n```\n\n<!-- fragment -->\n```python\nfail()\n```\n\n```python\nx = 1\n```\n"
    found = blocks(text)
    assert found == [Block("print(1)\n", "2\n"), Block("x = 1\n", None)]
    assert printed(found, tmp_path) == ["1\n", ""]
    assert agrees("a …\nc\n", "a b\nc\n")
    assert not agrees("2\n", "1\n")
    with pytest.raises(AssertionError, match="ZeroDivisionError"):
        printed([Block("1 / 0\n", None)], tmp_path)


def test_a_page_that_takes_long_is_noticed_by_the_work_it_does(tmp_path, monkeypatch):
    """Not by the clock: a page that waits, as all do on a machine that is busy, does no work."""
    monkeypatch.setattr(snippets, "MOST", 0.5)
    assert printed([Block("import time; time.sleep(1)\n", None)], tmp_path) == [""]
    with pytest.raises(AssertionError, match="of a processor"):
        printed([Block("import time\nwhile time.process_time() < 0.6: pass\n", None)], tmp_path)
