import torch


_joined = torch.stack


def _turned(angles):
    """Return the cosines and the sines of angles."""
    rows = torch.stack(torch.broadcast_tensors(*angles))
    return torch.unbind(torch.cos(rows)), torch.unbind(torch.sin(rows))

