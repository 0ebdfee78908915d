"""Values with named fields: ``dataclass`` and ``NamedTuple``, as the standard library has them, but made when used.

The library writes and compiles functions for each class where it is defined; of a run's time that was a tenth, mostly
for classes that it had few values of, or none. Here all classes share everything; one that many values are made of gets
its own ``__init__`` or ``__new__``. A type checker sees the library's.
"""

from __future__ import annotations

from _collections import _tuplegetter  # type: ignore[import-not-found]
from operator import attrgetter

from . import TYPE_CHECKING

if TYPE_CHECKING:
    from dataclasses import dataclass, field, replace
    from typing import NamedTuple
else:
    _MISSING = object()
    _MANY = 40  # values: so many take as long to make without a function of their class as that takes to compile

    class _Field:
        """What ``field`` says of one."""

        def __init__(self, default, default_factory, compare, hash, repr):  # noqa: A002
            self.default, self.factory = default, default_factory
            self.compare, self.repr = compare, repr
            self.hash = compare if hash is None else hash

    def field(*, default=_MISSING, default_factory=_MISSING, compare=True, hash=None, repr=True):  # noqa: A002
        """Say more of a field than its type, as ``dataclasses.field``."""
        return _Field(default, default_factory, compare, hash, repr)

    def dataclass(cls=None, /, *, frozen=False, eq=True, repr=True, kw_only=False):  # noqa: A002
        """Make a class one of values with named fields, as ``dataclasses.dataclass``."""
        if cls is None:
            return lambda cls: dataclass(cls, frozen=frozen, eq=eq, repr=repr, kw_only=kw_only)
        fields = dict(getattr(cls, "_record", ()))
        for name, kind in cls.__dict__.get("__annotations__", {}).items():
            if not str(kind).startswith("ClassVar"):
                fields[name] = _field_of(cls, name)
        cls._record = fields
        cls.__match_args__ = () if kw_only else tuple(fields)
        cls.__init__ = _first_init(cls, kw_only)
        cls.__dataclass_fields__ = _Fields()
        if repr and "__repr__" not in cls.__dict__:
            cls.__repr__ = _repr
        if eq:
            cls._compared = attrgetter(*[name for name, one in fields.items() if one.compare] or ["__class__"])
            cls._hashed = attrgetter(*[name for name, one in fields.items() if one.hash] or ["__class__"])
            cls.__eq__ = _equals
            cls.__hash__ = _hash if frozen else None
        if frozen:
            cls.__setattr__, cls.__delattr__ = _refuse, _refuse
        return cls

    def _field_of(cls, name):
        value = cls.__dict__.get(name, _MISSING)
        if not isinstance(value, _Field):
            return _Field(value, _MISSING, True, None, True)
        if value.default is _MISSING:
            delattr(cls, name)
        else:
            setattr(cls, name, value.default)
        return value

    def _first_init(cls, kw_only):
        made = 0
        then = hasattr(cls, "__post_init__")

        def __init__(self, /, *given, **named):
            nonlocal made
            made += 1
            if made < _MANY and not (kw_only and given) and _filled(self.__dict__, cls._record, given, named):
                if then:
                    self.__post_init__()
                return
            cls.__init__ = _own_init(cls, kw_only)
            cls.__init__(self, *given, **named)

        return __init__

    def _filled(own, fields, given, named):
        """Put the values of fields into a table; say whether the call was right: else a function has the words."""
        if len(given) > len(fields):
            return False
        values = dict(zip(fields, given))  # noqa: B905 - what is not given has a default, or a name
        if not values.keys().isdisjoint(named):
            return False
        values.update(named)
        for name, one in fields.items():
            if name in values:
                own[name] = values.pop(name)
            elif one.default is not _MISSING:
                own[name] = one.default
            elif one.factory is not _MISSING:
                own[name] = one.factory()
            else:
                return False
        return not values

    def _own_init(cls, kw_only):
        """Return the ``__init__`` of a class, with a parameter a field."""
        given, lines, known = ["self", "*"] if kw_only else ["self"], ["_own = self.__dict__"], {"_missing": _MISSING}
        for name, one in cls._record.items():
            known[f"_default_{name}"] = one.default if one.factory is _MISSING else one.factory
            if one.factory is not _MISSING:
                given.append(f"{name}=_missing")
                lines.append(f"_own[{name!r}] = _default_{name}() if {name} is _missing else {name}")
            else:
                given.append(name if one.default is _MISSING else f"{name}=_default_{name}")
                lines.append(f"_own[{name!r}] = {name}")
        if hasattr(cls, "__post_init__"):
            lines.append("self.__post_init__()")
        return _defined(cls, "__init__", given, lines, known)

    def _defined(cls, name, given, lines, known):
        exec(f"def {name}({', '.join(given)}):\n " + "\n ".join(lines), known)  # noqa: S102 - of names of fields
        made = known[name]
        made.__qualname__, made.__module__ = f"{cls.__qualname__}.{name}", cls.__module__
        return made

    def _repr(self):
        shown = [f"{name}={getattr(self, name)!r}" for name, one in self._record.items() if one.repr]
        return f"{type(self).__qualname__}({', '.join(shown)})"

    def _equals(self, other):
        if other.__class__ is not self.__class__:
            return NotImplemented
        return self._compared(self) == self._compared(other)

    def _hash(self):
        return hash(self._hashed(self))

    def _refuse(self, name, *_):
        from dataclasses import FrozenInstanceError

        raise FrozenInstanceError(f"cannot assign to field {name!r}")

    class _Fields:
        """The fields for ``dataclasses`` itself, made when it asks."""

        def __get__(self, _, cls):
            import dataclasses

            made = {}
            for name, one in cls._record.items():
                default = dataclasses.MISSING if one.default is _MISSING else one.default
                factory = dataclasses.MISSING if one.factory is _MISSING else one.factory
                made[name] = dataclasses.field(default=default, default_factory=factory, compare=one.compare)
                made[name].name, made[name]._field_type = name, dataclasses._FIELD
            return made

    def replace(value, /, **changes):
        """Return a value with some fields changed, as ``dataclasses.replace``."""
        cls, own = value.__class__, value.__dict__
        fields = getattr(cls, "_record", None)
        if fields is None or hasattr(cls, "__post_init__") or not changes.keys() <= fields.keys():
            names = fields or value.__dataclass_fields__
            return cls(**{name: own[name] for name in names if name not in changes}, **changes)
        made = object.__new__(cls)
        # What was worked out of the old one and stays with it is not the new one's.
        made.__dict__.update(own if len(own) == len(fields) else {name: own[name] for name in fields})
        made.__dict__.update(changes)
        return made

    class _Named(type):
        """Makes a class of tuples of a class with annotations."""

        def __new__(mcs, name, bases, members):
            if not bases:
                return super().__new__(mcs, name, (tuple,), members)
            if bases[0] is not NamedTuple:  # a class that adds methods to one that is made
                return super().__new__(mcs, name, bases, members)
            fields = tuple(members.get("__annotations__", ()))
            defaults = {one: members.pop(one) for one in fields if one in members}
            for number, one in enumerate(fields):
                members[one] = _tuplegetter(number, "")
            members |= {"_fields": fields, "_field_defaults": defaults, "__match_args__": fields, "__slots__": ()}
            own = "__new__" in members
            cls = type.__new__(mcs, name, (bases[0], *bases[1:]), members)
            if not own:
                cls.__new__ = _first_new(cls)
            return cls

    def _first_new(cls):
        made, fields, defaults = 0, cls._fields, cls._field_defaults

        def __new__(asked, /, *given, **named):
            nonlocal made
            made += 1
            whole = len(given) == len(fields) and not named
            values = given if whole else _completed(fields, defaults, given, named)
            if made < _MANY and values is not None:
                return tuple.__new__(asked, values)
            cls.__new__ = _own_new(cls)
            return cls.__new__(asked, *given, **named)

        return __new__

    def _completed(fields, defaults, given, named):
        """Return the values of all fields; None if the call was wrong: then a function has the words."""
        rest = fields[len(given) :]
        if len(given) > len(fields) or not named.keys() <= set(rest):
            return None
        values = {**defaults, **named}
        return (*given, *[values[name] for name in rest]) if values.keys() >= set(rest) else None

    def _own_new(cls):
        """Return the ``__new__`` of a class, with a parameter a field."""
        known = {"_new": tuple.__new__, **{f"_default_{name}": value for name, value in cls._field_defaults.items()}}
        given = [f"{name}=_default_{name}" if name in cls._field_defaults else name for name in cls._fields]
        values = "".join(f"{name}, " for name in cls._fields)
        return _defined(cls, "__new__", ["_cls", *given], [f"return _new(_cls, ({values}))"], known)

    class NamedTuple(metaclass=_Named):
        """A tuple with names, as ``typing.NamedTuple``."""

        __slots__ = ()

        @classmethod
        def _make(cls, values):
            return tuple.__new__(cls, values)

        def _replace(self, /, **changes):
            made = tuple.__new__(type(self), map(changes.pop, self._fields, self))
            if changes:
                raise ValueError(f"Got unexpected field names: {list(changes)!r}")
            return made

        def _asdict(self):
            return dict(zip(self._fields, self, strict=True))

        def __getnewargs__(self):
            return tuple(self)

        def __repr__(self):
            return f"{type(self).__name__}({', '.join(f'{n}={v!r}' for n, v in zip(self._fields, self, strict=True))})"


__all__ = ["NamedTuple", "dataclass", "field", "replace"]
