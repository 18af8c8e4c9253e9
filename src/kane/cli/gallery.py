# SPDX-License-Identifier: BSD-3-Clause
"""`kane gallery`: the systems that come with kane."""

from kane.cli import screen
from kane.cli.options import AsJson
from kane.gallery import GALLERY, load


def gallery(as_json: AsJson = False) -> None:
    """List the systems of the gallery; each can be given as MODEL."""
    titles = {name: str(load(name).TITLE) for name in GALLERY}
    if as_json:
        screen.as_json([{"name": name, "title": title} for name, title in titles.items()])
    else:
        screen.table(list(titles.items()), indent=0)
