"""The built documentation loads nothing from elsewhere, and every link within it leads somewhere.

usage: docs.py build/docs
"""

import re
import sys
from collections.abc import Iterator
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

LOADING = {  # tag: attributes whose address a browser loads by itself
    "script": ("src",),
    "img": ("src", "srcset"),
    "link": ("href",),
    "iframe": ("src",),
    "source": ("src", "srcset"),
    "video": ("src", "poster"),
    "object": ("data",),
}
LOADED_BY_STYLE = re.compile(r"(?:@import\s+|url\(\s*)[\"']?((?:https?:)?//[^\"')\s]+)")


class Page(HTMLParser):
    """What a page loads, where it leads, and the places in it that can be led to."""

    def __init__(self, path: Path) -> None:
        """Read a page."""
        super().__init__()
        self.loaded: list[str] = []
        self.links: list[str] = []
        self.places = {""}
        self.feed(path.read_text())

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Note a tag's addresses and place."""
        given = {name: value or "" for name, value in attrs}
        self.places |= {given[name] for name in ("id", "name") if name in given}
        self.loaded += [given[name] for name in LOADING.get(tag, ()) if name in given]
        if tag == "a" and "href" in given:
            self.links.append(given["href"])


def main() -> None:
    """Look through the folder named on the command line; leave with a list of what is wrong."""
    folder = Path(sys.argv[1]).resolve()
    pages = {path: Page(path) for path in sorted(folder.rglob("*.html"))}
    if not pages:
        sys.exit(f"{folder}: no page found")
    wrong = [*loaded_from_elsewhere(folder, pages), *leading_nowhere(pages)]
    for line in wrong:
        print(line)
    links = sum(len(page.links) for page in pages.values())
    print(f"{len(pages)} pages, {links} links, {len(wrong)} wrong")
    sys.exit(bool(wrong))


def loaded_from_elsewhere(folder: Path, pages: dict[Path, Page]) -> Iterator[str]:
    """Yield what pages and their styles load that does not lie in the folder."""
    for path, page in pages.items():
        for address in page.loaded:
            if not is_within(address) or not target_of(path, address).exists():
                yield f"{path.name} loads {address[:100]}"
    for path in sorted(folder.rglob("*.css")):
        for address in LOADED_BY_STYLE.findall(path.read_text()):
            yield f"{path.name} loads {address}"


def leading_nowhere(pages: dict[Path, Page]) -> Iterator[str]:
    """Yield links to files or places that do not exist."""
    for path, page in pages.items():
        for address in filter(is_within, page.links):
            target, place = target_of(path, address), unquote(urlsplit(address).fragment)
            there = target.exists() and (target not in pages or place in pages[target].places)
            if not there:
                yield f"{path.name} leads to {address}"


def is_within(address: str) -> bool:
    """Tell whether an address has neither a scheme nor a host."""
    parts = urlsplit(address)
    return not (parts.scheme or parts.netloc)


def target_of(path: Path, address: str) -> Path:
    """Return the file to which an address on a page leads."""
    relative = unquote(urlsplit(address).path)
    return (path.parent / relative).resolve() if relative else path


if __name__ == "__main__":
    main()
