"""The grammar of PLY: a header that declares elements, and their rows as text or as bytes of either order.

Format: G. Turk, "The PLY Polygon File Format", 1994. What the header claims is checked against the length of the file
before anything of that size is allocated.
"""

import re
import struct
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from subdfit.errors import InputError
from subdfit.io.text import floats, integers, quote, row_of
from subdfit.wording import counted

_TYPES = {
    **dict.fromkeys(("char", "int8"), "i1"),
    **dict.fromkeys(("uchar", "uint8"), "u1"),
    **dict.fromkeys(("short", "int16"), "i2"),
    **dict.fromkeys(("ushort", "uint16"), "u2"),
    **dict.fromkeys(("int", "int32"), "i4"),
    **dict.fromkeys(("uint", "uint32"), "u4"),
    **dict.fromkeys(("float", "float32"), "f4"),
    **dict.fromkeys(("double", "float64"), "f8"),
}
_BYTE_ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
_STRUCT_CODES = {"i1": "b", "u1": "B", "i2": "h", "u2": "H", "i4": "i", "u4": "I"}
_END = re.compile(rb"^end_header[ \t]*(\r\n|\n|\r|$)", re.MULTILINE)


@dataclass(frozen=True)
class Property:
    """A column: numpy type of its values and, for a list, of the count before them (None for a scalar)."""

    name: str
    kind: str
    count_kind: str | None


@dataclass
class Element:
    """A table of `count` rows."""

    name: str
    count: int
    properties: list[Property]


@dataclass(frozen=True)
class Header:
    """What the header says; `byte_order` is empty for text, `start` the first byte after it."""

    byte_order: str
    elements: list[Element]
    comments: list[str]
    start: int


class Lists(NamedTuple):
    """A list column: the number of values in each row, and all values in a row."""

    sizes: NDArray[np.int64]
    values: NDArray[Any]


Column = NDArray[Any] | Lists
Table = dict[str, Column]


def parse_header(content: bytes, name: str) -> Header:
    """Read the header; raises InputError that quotes the first line it cannot make sense of."""
    content_start = content[:4].split()
    end = _END.search(content.replace(b"\r", b"\n") if b"\n" not in content[:2000] else content)
    if content_start[:1] != [b"ply"]:
        raise InputError(f"{name}: line 1 is not the word ply; the file is no PLY file, check its extension")
    if end is None:
        raise InputError(f"{name}: the header has no end_header; the file is cut, export it again")
    byte_order, elements, comments = None, list[Element](), list[str]()
    for number, raw in enumerate(content[: end.start()].splitlines()[1:], 2):
        line = raw.decode("latin-1").strip()
        words = line.split()
        try:
            match words:
                case [] | ["obj_info", *_]:
                    pass
                case ["comment", *_]:
                    comments.append(line[len("comment") :].strip())
                case ["format", kind, "1.0"] if byte_order is None:
                    byte_order = _BYTE_ORDERS[kind]
                case ["element", element, count] if count.isascii() and count.isdigit():
                    elements.append(Element(element, int(count), []))
                case ["property", "list", count_kind, kind, column] if _TYPES[count_kind] in _STRUCT_CODES:
                    elements[-1].properties.append(Property(column, _TYPES[kind], _TYPES[count_kind]))
                case ["property", kind, column]:
                    elements[-1].properties.append(Property(column, _TYPES[kind], None))
                case _:
                    raise KeyError(line)
        except (KeyError, IndexError, ValueError):
            raise InputError(f"{name}: line {number} '{quote(raw)}' is no PLY header line; export it again") from None
    if byte_order is None:
        raise InputError(f"{name}: the header states no format (ascii, binary_little_endian or binary_big_endian)")
    _refuse_doubles(elements, name)
    return Header(byte_order, elements, comments, end.end())


def _refuse_doubles(elements: list[Element], name: str) -> None:
    for kind, names in [
        ("element", [element.name for element in elements]),
        *((f"{element.name} property", [p.name for p in element.properties]) for element in elements),
    ]:
        if len(set(names)) < len(names):
            raise InputError(f"{name}: the header declares an {kind} twice; export the file again")


def parse_tables(content: bytes, header: Header, wanted: dict[str, set[str]], name: str) -> dict[str, Table]:
    """Read the `wanted` columns of all elements; raises InputError where header and body disagree."""
    body: _Text | _Binary
    body = _Binary(content, header, name) if header.byte_order else _Text(content[header.start :].split(), name)
    tables = {e.name: body.table(e, wanted.get(e.name, set())) for e in header.elements}
    body.check_end()
    return tables


def _cut(name: str, element: Element, unit: str, has: int) -> InputError:
    return InputError(
        f"{name}: the header states {counted(element.count, 'row')} of '{element.name}', more than the {has} "
        f"{unit} left hold; the file is cut or contradictory, export it again"
    )


class _Binary:
    """Rows as bytes."""

    def __init__(self, content: bytes, header: Header, name: str) -> None:
        self.content, self.position, self.name, self.order = content, header.start, name, header.byte_order

    def table(self, element: Element, wanted: set[str]) -> Table:
        """Read an element: at once when all its rows are alike, else row by row."""
        left = len(self.content) - self.position
        least = sum(np.dtype(p.count_kind or p.kind).itemsize for p in element.properties)
        if element.count * least > left:
            raise _cut(self.name, element, "bytes", left)
        if element.count == 0 or not element.properties:
            return _empty(element, wanted)
        return self._alike(element, wanted) or self._ragged(element, wanted)

    def check_end(self) -> None:
        """Refuse bytes that no element accounts for."""
        extra = len(self.content) - self.position
        if extra and self.content[self.position :].strip():
            raise InputError(
                f"{self.name}: {counted(extra, 'byte')} after the last row the header states; export it again"
            )

    def _alike(self, element: Element, wanted: set[str]) -> Table | None:
        """Read all rows with the layout of the first one; None if that is not the layout of all."""
        left = len(self.content) - self.position
        sizes, fields, at = [], list[tuple[str, str, int]](), self.position
        for i, p in enumerate(element.properties):
            size = 1
            if p.count_kind:
                size = self._count(p.count_kind, at, element, 0)
                at += np.dtype(p.count_kind).itemsize
                fields.append((f"count {i}", self.order + p.count_kind, 1))
            at += size * np.dtype(p.kind).itemsize
            sizes.append(size)
            fields.append((f"value {i}", self.order + p.kind, size))
        row_bytes = at - self.position
        if row_bytes * element.count > left or row_bytes >= 2**31:
            return None
        dtype = np.dtype([(key, kind, (size,)) for key, kind, size in fields])
        rows = np.frombuffer(self.content, dtype, element.count, self.position)
        lists = [i for i, p in enumerate(element.properties) if p.count_kind]
        if any((rows[f"count {i}"] != sizes[i]).any() for i in lists):
            return None
        self.position += row_bytes * element.count
        table: Table = {}
        for i, p in enumerate(element.properties):
            if p.name in wanted:
                values = rows[f"value {i}"].ravel()
                table[p.name] = Lists(np.full(element.count, sizes[i], np.int64), values) if p.count_kind else values
        return table

    def _ragged(self, element: Element, wanted: set[str]) -> Table:
        """Walk over the rows for where each value starts, then gather each column."""
        starts: list[list[int]] = [[] for _ in element.properties]
        sizes: list[list[int]] = [[] for _ in element.properties]
        plan = [
            (p.count_kind, np.dtype(p.count_kind or "u1").itemsize, np.dtype(p.kind).itemsize, starts[i], sizes[i])
            for i, p in enumerate(element.properties)
        ]
        content, at, end = self.content, self.position, len(self.content)
        for row in range(element.count):
            for count_kind, count_bytes, value_bytes, row_starts, row_sizes in plan:
                size = 1
                if count_kind == "u1" and at < end:
                    size = content[at]
                    at += 1
                elif count_kind:
                    size = self._count(count_kind, at, element, row)
                    at += count_bytes
                row_starts.append(at)
                row_sizes.append(size)
                at += size * value_bytes
            if at > end:
                raise self._ends(element, row)
        self.position = at
        table: Table = {}
        for i, p in enumerate(element.properties):
            if p.name in wanted:
                lengths = np.array(sizes[i], np.int64)
                values = self._gather(np.array(starts[i], np.int64), lengths, np.dtype(self.order + p.kind))
                table[p.name] = Lists(lengths, values) if p.count_kind else values
        return table

    def _gather(self, starts: NDArray[np.int64], sizes: NDArray[np.int64], kind: np.dtype[Any]) -> NDArray[Any]:
        source = np.frombuffer(self.content, np.uint8)
        values = np.empty(int(sizes.sum()), kind)
        into = np.cumsum(sizes) - sizes
        for size in np.unique(sizes):
            rows = np.flatnonzero(sizes == size)
            taken = source[starts[rows, None] + np.arange(size * kind.itemsize)]
            values[into[rows, None] + np.arange(size)] = np.ascontiguousarray(taken).view(kind)
        return values

    def _count(self, kind: str, at: int, element: Element, row: int) -> int:
        try:
            count: int = struct.unpack_from(self.order + _STRUCT_CODES[kind], self.content, at)[0]
        except struct.error:
            raise self._ends(element, row) from None
        if count < 0:
            raise InputError(
                f"{self.name}: row {row} of '{element.name}' states {counted(count, 'value')}; export the file again"
            )
        return count

    def _ends(self, element: Element, row: int) -> InputError:
        return InputError(
            f"{self.name}: the file ends in row {row} of '{element.name}', the header states {element.count}; "
            "it is cut or contradictory, export it again"
        )


class _Text:
    """Rows as words."""

    def __init__(self, words: list[bytes], name: str) -> None:
        self.words, self.position, self.name = words, 0, name

    def table(self, element: Element, wanted: set[str]) -> Table:
        """Read an element: at once when all its rows are alike, else row by row."""
        left = len(self.words) - self.position
        if element.count * len(element.properties) > left:
            raise _cut(self.name, element, "words", left)
        if element.count == 0 or not element.properties:
            return _empty(element, wanted)
        columns = self._alike(element) or self._ragged(element)
        table: Table = {}
        for p, (sizes, words) in zip(element.properties, columns, strict=True):
            if p.name in wanted:
                table[p.name] = self._values(element, p, sizes, words)
        return table

    def check_end(self) -> None:
        """Refuse words that no element accounts for."""
        extra = len(self.words) - self.position
        if extra:
            raise InputError(
                f"{self.name}: {counted(extra, 'word')} after the last row the header states; export it again"
            )

    def _values(self, element: Element, p: Property, sizes: NDArray[np.int64], words: list[bytes]) -> Column:
        def place(word: int) -> str:
            return f"{self.name}: row {row_of(word, sizes)} of '{element.name}', {p.name}"

        values: NDArray[Any] = (floats if p.kind[0] == "f" else integers)(words, place)
        return Lists(sizes, values) if p.count_kind else values

    def _alike(self, element: Element) -> list[tuple[NDArray[np.int64], list[bytes]]] | None:
        """Read all rows with the layout of the first one; None if that is not the layout of all."""
        spans, width = [], 0
        for p in element.properties:
            size = self._count(self.position + width, element, 0) if p.count_kind else 1
            first = width + bool(p.count_kind)
            spans.append((first, size))
            width = first + size
        block = self.words[self.position : self.position + width * element.count]
        counted = [first - 1 for p, (first, _) in zip(element.properties, spans, strict=True) if p.count_kind]
        if len(block) < width * element.count or any(len(set(block[at::width])) > 1 for at in counted):
            return None
        self.position += len(block)
        columns = []
        for first, size in spans:
            words = [b""] * (size * element.count)
            for i in range(size):
                words[i::size] = block[first + i :: width]
            columns.append((np.full(element.count, size, np.int64), words))
        return columns

    def _ragged(self, element: Element) -> list[tuple[NDArray[np.int64], list[bytes]]]:
        sizes: list[list[int]] = [[] for _ in element.properties]
        taken: list[list[bytes]] = [[] for _ in element.properties]
        at = self.position
        for row in range(element.count):
            for i, p in enumerate(element.properties):
                size = 1
                if p.count_kind:
                    size = self._count(at, element, row)
                    at += 1
                sizes[i].append(size)
                taken[i] += self.words[at : at + size]
                at += size
            if at > len(self.words):
                raise self._ends(element, row)
        self.position = at
        return [(np.array(rows, np.int64), words) for rows, words in zip(sizes, taken, strict=True)]

    def _count(self, at: int, element: Element, row: int) -> int:
        if at >= len(self.words):
            raise self._ends(element, row)
        word = self.words[at]
        if not word.isdigit() or len(word) > 9:
            raise InputError(f"{self.name}: row {row} of '{element.name}' states '{quote(word)}' values; mend the row")
        return int(word)

    def _ends(self, element: Element, row: int) -> InputError:
        return InputError(
            f"{self.name}: the file ends in row {row} of '{element.name}', the header states {element.count}; "
            "it is cut or contradictory, export it again"
        )


def _empty(element: Element, wanted: set[str]) -> Table:
    none = np.empty(0, np.int64)
    return {p.name: Lists(none, none) if p.count_kind else none for p in element.properties if p.name in wanted}
