{% set title = "PyTorch" %}
{% set needs = "torch, and nothing else" %}
{% set transforms = "Gradients and torch.func apply to the functions, also by X." %}
{% set array = "torch.as_tensor" %}
{% macro entries(name) %}torch.unbind({{ name }}, -1){% endmacro %}
{% macro head() %}
import torch


def _joined(values, axis, places=None):
    """Stack tensors, and take the rows at these places."""
    rows = torch.stack(values, axis)
    return rows if places is None else rows[..., places]


def _turned(angles):
    """Return the cosines and the sines of angles."""
    rows = torch.stack(torch.broadcast_tensors(*angles))
    return torch.unbind(torch.cos(rows)), torch.unbind(torch.sin(rows))
{% endmacro %}
