"""A small PointNet++ for segmentation: two levels of neighbourhoods, a code of the whole cloud, and back up."""

from __future__ import annotations

import torch
from torch import nn

LEVELS = ((64, 16, (32, 64)), (16, 16, (64, 128)))  # centres, neighbours of each, widths
CODE, KIND = 128, 16


def shared(*widths: int) -> nn.Sequential:
    """The same layers for every point (..., width)."""
    layers: list[nn.Module] = []
    for a, b in zip(widths, widths[1:], strict=False):
        layers += [nn.Linear(a, b), nn.LayerNorm(b), nn.ReLU()]
    return nn.Sequential(*layers)


def gather(values: torch.Tensor, index: torch.Tensor) -> torch.Tensor:
    """Rows (B, ..., d) of ``values`` (B, n, d) by ``index`` (B, ...)."""
    flat = index.reshape(len(index), -1, 1).expand(-1, -1, values.shape[-1])
    return values.gather(1, flat).reshape(*index.shape, values.shape[-1])


class Segmenter(nn.Module):
    """Clouds (B, n, 3) whose points stand in random order, and the number of the category of each (B,), to a number per point (B, n):
    above 0, it moves."""

    def __init__(self, categories: int) -> None:
        super().__init__()
        self.kind = nn.Embedding(categories, KIND)
        width, self.down, self.up = 0, nn.ModuleList(), nn.ModuleList()
        skips = [0]
        for _, _, widths in LEVELS:
            self.down.append(shared(3 + 3 + width, *widths))
            width = widths[-1]
            skips.append(width)
        self.whole = shared(3 + width + KIND, CODE)
        above = CODE
        for skip in reversed(skips):
            self.up.append(shared(above + skip + 3 + KIND, 64))
            above = 64
        self.last = nn.Linear(64, 1)

    def forward(self, points: torch.Tensor, category: torch.Tensor) -> torch.Tensor:
        kind = self.kind(category)[:, None]
        levels: list[tuple[torch.Tensor, torch.Tensor | None]] = [(points, None)]
        for (count, near, _), layer in zip(LEVELS, self.down, strict=True):
            above, features = levels[-1]
            centres = above[:, :count]  # in random order, the first ones are a random choice
            index = torch.cdist(centres, above).topk(near, largest=False).indices
            offset = gather(above, index) - centres[:, :, None]
            parts = [offset, centres[:, :, None].expand_as(offset)]
            if features is not None:
                parts.append(gather(features, index))
            levels.append((centres, layer(torch.cat(parts, dim=-1)).amax(dim=2)))
        centres, features = levels[-1]
        assert features is not None
        code = self.whole(torch.cat([centres, features, kind.expand(-1, centres.shape[1], -1)], dim=-1)).amax(
            dim=1, keepdim=True
        )
        found, below = code.expand(-1, centres.shape[1], -1), centres
        for (place, own), layer in zip(reversed(levels), self.up, strict=True):
            if place is not below:  # from the three nearest of the coarser level
                distance, index = torch.cdist(place, below).topk(3, largest=False)
                weight = 1.0 / (distance + 1e-6)
                found = (gather(found, index) * (weight / weight.sum(dim=-1, keepdim=True))[..., None]).sum(dim=2)
            given = [found, place, kind.expand(-1, place.shape[1], -1)]
            found = layer(torch.cat(given if own is None else [*given, own], dim=-1))
            below = place
        return self.last(found)[..., 0]
