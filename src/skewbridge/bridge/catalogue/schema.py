"""JSON schema of a bridge file, for editors: the typed form, a source beside each number."""

from typing import Any

from skewbridge.bridge.catalogue.data import BridgeData
from skewbridge.bridge.catalogue.loading import SOURCE_PATTERN


def bridge_schema() -> dict[str, Any]:
    """Return the JSON schema of a bridge file.

    A file that extends another one may leave out every key; one that stands alone needs those
    of the top level.
    """
    schema = BridgeData.model_json_schema()
    kinds: dict[str, Any] = schema["$defs"]
    for part in (schema, *kinds.values()):
        if "properties" in part:
            part["properties"] = {
                name: _with_source(field, kinds) for name, field in part["properties"].items()
            }
    needed = [name for name in schema.pop("required") if name not in {"name", "sources"}]
    for part in kinds.values():
        part.pop("required", None)
    for name in ("name", "sources"):
        del schema["properties"][name]
    schema["properties"]["extends"] = {
        "type": "string",
        "description": "name of the bridge that this one starts from",
    }
    schema["anyOf"] = [{"required": ["extends"]}, {"required": needed}]
    return schema


def _with_source(field: dict[str, Any], kinds: dict[str, Any]) -> dict[str, Any]:
    """Return a field as the file writes it: numbers as value and source, the rest as it is."""
    known = [option for option in field.get("anyOf", [field]) if option.get("type") != "null"]
    if not _is_number(known[0], kinds):
        return field
    source = {"type": "string", "pattern": f"^{SOURCE_PATTERN}$"}
    return {
        "type": "object",
        "properties": {"v": known[0], "src": source},
        "required": ["v", "src"],
        "additionalProperties": False,
    }


def _is_number(field: dict[str, Any], kinds: dict[str, Any]) -> bool:
    told = kinds[field["$ref"].rsplit("/", 1)[1]] if "$ref" in field else field
    if told.get("type") == "array":
        return _is_number(told.get("items") or told["prefixItems"][0], kinds)
    return told.get("type") in {"number", "integer"}
