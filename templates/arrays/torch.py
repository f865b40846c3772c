{% set title = "PyTorch" %}
{% set needs = "torch, and nothing else" %}
{% set transforms = "Gradients and torch.func apply to the functions, also by X." %}
{% macro converted(names) %}{{ names | join(", ") }}{{ "," if names | length == 1 }} = _tensors({{ names | join(", ") }}){% endmacro %}
{% macro entries(name) %}torch.unbind({{ name }}, -1){% endmacro %}
{% macro head() %}
import torch


def _tensors(*inputs):
    """Return tensors. What is none gets the type and the device of the first floating one."""
    known = [x for x in inputs if torch.is_tensor(x) and x.is_floating_point()]
    if not known:
        return [torch.as_tensor(x) for x in inputs]
    like = {"dtype": known[0].dtype, "device": known[0].device}
    return [x if torch.is_tensor(x) else torch.as_tensor(x, **like) for x in inputs]


def _joined(values, axis, places=None):
    """Stack tensors, and take the rows at these places."""
    rows = torch.stack(values, axis)
    return rows if places is None else rows[..., places]


def _turned(angles):
    """Return the cosines and the sines of angles."""
    rows = torch.stack(torch.broadcast_tensors(*angles))
    return torch.unbind(torch.cos(rows)), torch.unbind(torch.sin(rows))
{% endmacro %}
