"""Object dictionaries from EDS files: python-canopen reads them, durand serves them."""

import configparser
import functools
import io
import re

import canopen.objectdictionary
import canopen.objectdictionary.eds
from durand import DatatypeEnum, Record, Variable
from durand.object_dictionary import ObjectDictionary

FIRST_PROFILE_OBJECT = 0x2000
MANDATORY = ("1000", "1001", "1018")
ABSENT = "0x0"  # ObjectType NULL: the object is not there
ACCESS = {"rwr": "rw", "rww": "rw"}


@functools.cache
def merged(files):
    """The text of the EDS that remains when each file overrides those before it."""
    eds = configparser.RawConfigParser(inline_comment_prefixes=(";",))
    eds.optionxform = str
    eds.read(files, encoding="utf-8")
    for section in eds.sections():
        if eds.get(section, "ObjectType", fallback=None) == ABSENT:
            for part in [name for name in eds.sections() if name == section or name.startswith(f"{section}sub")]:
                eds.remove_section(part)
    objects = sorted(section for section in eds.sections() if re.fullmatch("[0-9A-F]{4}", section))
    for name, listed in (
        ("MandatoryObjects", [index for index in objects if index in MANDATORY]),
        ("OptionalObjects", [index for index in objects if index not in MANDATORY]),
    ):
        eds[name] = {"SupportedObjects": len(listed)} | {number: f"0x{index}" for number, index in enumerate(listed, 1)}
    text = io.StringIO()
    eds.write(text, space_around_delimiters=False)
    return text.getvalue()


@functools.cache
def read(eds, node):
    """What python-canopen makes of the text of an EDS."""
    return canopen.objectdictionary.eds.import_eds(io.StringIO(eds), node)


class Entries(Record):
    """A record or an array with the sub-index 0 that the EDS declares."""

    def __getitem__(self, subindex):
        return self._variables[subindex]

    def __contains__(self, subindex):
        return subindex in self._variables

    def __iter__(self):
        return iter(sorted(self._variables.items()))


class Dictionary(ObjectDictionary):
    """What an EDS declares, and nothing else: what the library would add by itself is left out."""

    def __init__(self, eds, node):
        super().__init__()
        self.mappable = set()
        self.defaults = {}
        for entry in read(eds, node).values():
            super().__setitem__(entry.index, self._object(entry))

    def __setitem__(self, index, entry):
        pass

    def has(self, index, subindex=0):
        return (index, subindex) in self.defaults

    def lookup(self, index, subindex=None):
        if subindex and index in self._variables:
            raise KeyError(f"{index:04X}h has no sub-index {subindex}")
        return super().lookup(index, subindex)

    def stored(self, index, subindex):
        """The value as it was written, whatever a reader is told."""
        return self._data[(index, subindex)]

    def pdos(self, first_index):
        """How many communication parameters there are, without a gap."""
        number = 0
        while self.has(first_index + number, 1):
            number += 1
        return number

    def _object(self, entry):
        if isinstance(entry, canopen.objectdictionary.ODVariable):
            return self._variable(entry)
        entries = Entries(entry.name)
        for member in entry.values():
            entries[member.subindex] = self._variable(member)
        return entries

    def _variable(self, entry):
        kind = DatatypeEnum(entry.data_type)
        value = entry.value if entry.value is not None else entry.default
        if isinstance(value, str):
            value = value.encode()
        if entry.pdo_mappable:
            self.mappable.add((entry.index, entry.subindex))
        access = ACCESS.get(entry.access_type, entry.access_type)
        variable = Variable(kind, access, value, minimum=entry.min, maximum=entry.max, name=entry.name)
        self.defaults[(entry.index, entry.subindex)] = 0 if value is None else value
        return variable
