"""A small, safe XML reader that records the byte position of every element.

Expat parses the text. Document types and entities are refused, so no text expands and no file is
fetched.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from xml.parsers import expat
from xml.sax.saxutils import escape

from symgen.errors import RobotError

#: A tag from start to end; quoted values may contain '>'.
_TAG = re.compile(rb"""[^>"']*(?:(?:"[^"]*"|'[^']*')[^>"']*)*>""")


#: An attribute of a tag.
_ATTRIBUTE = re.compile(rb"""\s+([^\s=>/]+)\s*=\s*("[^"]*"|'[^']*')""")
#: Attributes with paths relative to the file: `filename` in a URDF, the others in an MJCF.
_PATHS = {
    "mesh": ("filename",),
    "texture": ("filename",),
    "include": ("file",),
    "compiler": ("assetdir", "meshdir", "texturedir"),
}
#: An edit of a text: first and end byte to replace, and the new content.
Edit = tuple[int, int, bytes]


@dataclass
class Element:
    """One element: tag, attributes, and byte positions in the UTF-8 text.

    Attributes:
        text: the last text directly inside the element.
        start: first byte of the start tag.
        inside: first byte after the start tag.
        close: first byte of the end tag; equals `inside` if there is no content.
        end: first byte after the end tag.
    """

    tag: str
    attributes: dict[str, str]
    line: int
    start: int
    inside: int = 0
    close: int = 0
    end: int = 0
    children: list[Element] = field(default_factory=list)
    text: str = ""

    def all(self, tag: str) -> list[Element]:
        """Return the children with this tag."""
        return [child for child in self.children if child.tag == tag]

    def walk(self, tag: str) -> Iterator[Element]:
        """Yield all elements with this tag inside this one."""
        waiting = list(self.children)
        while waiting:
            element = waiting.pop()
            waiting += element.children
            if element.tag == tag:
                yield element

    def first(self, tag: str) -> Element | None:
        """Return the first child with this tag, or None."""
        return next(iter(self.all(tag)), None)


def parse_xml(text: str) -> Element:
    """Return the root element of an XML text.

    Raises:
        RobotError: the text is not well formed, or declares a document type or an entity.
    """
    content = text.encode("utf-8")
    parser = expat.ParserCreate("UTF-8")
    parser.buffer_text = True
    roots: list[Element] = []
    stack: list[Element] = []

    def start(tag: str, attributes: dict[str, str]) -> None:
        at = parser.CurrentByteIndex
        element = Element(tag, attributes, parser.CurrentLineNumber, at)
        element.inside = element.close = _tag_end(content, at)
        (stack[-1].children if stack else roots).append(element)
        stack.append(element)

    def read(text: str) -> None:
        stack[-1].text = text

    def end(_: str) -> None:
        element = stack.pop()
        at = parser.CurrentByteIndex
        # For <link/>, expat reports the end at or after its only tag.
        empty = content[element.inside - 2 : element.inside] == b"/>"
        element.close = element.inside if empty else at
        element.end = element.inside if empty else _tag_end(content, at)

    def refuse(*_: object) -> None:
        raise RobotError(
            f"line {parser.CurrentLineNumber}: DOCTYPE and ENTITY are not accepted; "
            "accepted: plain XML"
        )

    parser.StartElementHandler = start
    parser.EndElementHandler = end
    parser.CharacterDataHandler = read
    parser.StartDoctypeDeclHandler = refuse
    parser.EntityDeclHandler = refuse
    try:
        parser.Parse(content, True)
    except (expat.ExpatError, ValueError) as error:  # ValueError: an unknown encoding
        raise RobotError(f"not well-formed XML: {error}") from error
    return roots[0]


def edited(text: str, edits: Iterable[Edit]) -> str:
    """Return a text with some bytes of its UTF-8 form replaced; edits must not overlap.

    Edits at one position are inserted in their order.
    """
    content = text.encode("utf-8")
    for start, end, new in sorted(edits, key=lambda edit: edit[:2])[::-1]:
        content = content[:start] + new + content[end:]
    return content.decode("utf-8")


def with_attributes(content: bytes, element: Element, values: Mapping[str, str]) -> Edit:
    """Return the edit that sets attributes of an element; all other bytes of its tag stay the same.

    Args:
        content: the UTF-8 text of the file.
        element: element of the file.
        values: name -> value, without characters that XML escapes.
    """
    tag, waiting = content[element.start : element.inside], dict(values)
    first = 1 + len(element.tag.encode())
    out, at = [tag[:first]], first
    while (found := _ATTRIBUTE.match(tag, at)) is not None:
        name, at = found.group(1).decode(), found.end()
        kept = found.group(0)
        if name in waiting:
            kept = kept[: found.start(2) - found.start()] + f'"{waiting.pop(name)}"'.encode()
        out.append(kept)
    new = "".join(f' {name}="{value}"' for name, value in waiting.items())
    return element.start, element.inside, b"".join([*out, new.encode(), tag[at:]])


def inserted(content: bytes, element: Element, lines: Iterable[str]) -> Edit:
    """Return the edit that inserts lines at the end of an element, indented by two more than it.

    Args:
        content: the UTF-8 text of the file.
        element: element of the file.
        lines: lines of XML.
    """
    margin = content[content.rfind(b"\n", 0, element.start) + 1 : element.start]
    indent = margin.decode("utf-8") if not margin.strip() else ""
    new = "".join(f"\n{indent}  {line}" for line in lines)
    if element.end > element.close:  # it has an end tag
        blank = len(content[: element.close]) - len(content[: element.close].rstrip())
        at = element.close - blank
        return at, element.close, f"{new}\n{indent}".encode()
    tag = content[element.start : element.inside].removesuffix(b"/>").rstrip()
    closed = f">{new}\n{indent}</{element.tag}>"
    return element.start, element.inside, tag + closed.encode()


def relocated(text: str, source: Path, folder: Path) -> str:
    """Return a URDF or MJCF for another folder, with its relative paths adapted.

    Args:
        text: text of the file.
        source: path of the file.
        folder: the new folder. The text stays unchanged if it is that of the file.
    """
    here, there = source.parent.resolve(), folder.resolve()
    if here == there:
        return text

    def moved(path: str) -> str:
        if "://" in path or os.path.isabs(path):
            return escape(path, {'"': "&quot;"})
        return escape(Path(os.path.relpath(here / path, there)).as_posix(), {'"': "&quot;"})

    root, content, edits = parse_xml(text), text.encode("utf-8"), list[Edit]()
    compilers = list(root.walk("compiler"))
    named = {key for element in compilers for key in element.attributes}
    kinds = ("include", "mesh", "texture", "hfield", "skin")
    read = any("file" in element.attributes for kind in kinds for element in root.walk(kind))
    added = {
        key: moved("") for key in ("meshdir", "texturedir")
        if root.tag == "mujoco" and read and not named & {key, "assetdir"}
    }  # fmt: skip
    if added and not compilers:
        words = " ".join(f'{key}="{value}"' for key, value in added.items())
        edits.append(inserted(content, root, [f"<compiler {words}/>"]))
    for tag, keys in _PATHS.items():
        for element in root.walk(tag):
            values = {k: moved(element.attributes[k]) for k in keys if k in element.attributes}
            if compilers and element is compilers[0]:
                values |= added
            if values:
                edits.append(with_attributes(content, element, values))
    return edited(text, edits)


def _tag_end(content: bytes, at: int) -> int:
    """Return the position after the tag that begins at `at`; quoted values may contain '>'."""
    tag = _TAG.match(content, at)
    return tag.end() if tag else len(content)
