# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""YAML from untrusted hands: plain data only, no key twice, every refusal with line and column."""

from __future__ import annotations

from typing import Any

import yaml


class YamlTextError(ValueError):
    """The text is not acceptable YAML; the message has place and reason, without a file name."""


class _PlainLoader(yaml.SafeLoader):
    """The loader of `yaml.safe_load`, which also refuses a key that is given twice."""

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Any, Any]:
        seen: dict[str, int] = {}
        for key, _ in node.value:
            if isinstance(key, yaml.ScalarNode):
                if key.value in seen:
                    raise yaml.constructor.ConstructorError(
                        problem=f"key '{key.value}' is given twice, "
                        f"first in line {seen[key.value] + 1}",
                        problem_mark=key.start_mark,
                    )
                seen[key.value] = key.start_mark.line
        return super().construct_mapping(node, deep)


def plain_data(text: str) -> Any:
    """Read one YAML document of mappings, lists, numbers, booleans and text.

    Raises:
        YamlTextError: Wrong syntax, a tag that would make a Python object, a key given twice, a
            second document, or nesting without end.
    """
    try:
        return yaml.load(text, Loader=_PlainLoader)
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        where = f"line {mark.line + 1}, column {mark.column + 1}: " if mark else ""
        problems = [str(part) for part in (error.context, error.problem) if part]
        raise YamlTextError(where + ", ".join(problems)) from error
    except RecursionError as error:
        raise YamlTextError("nested too deeply") from error
    except (yaml.YAMLError, ValueError) as error:
        raise YamlTextError(" ".join(str(error).split())) from error
