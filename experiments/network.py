"""A small PointNet++: two levels of neighbourhoods, a code of the whole cloud, and back up to the points."""

from __future__ import annotations

import torch
from torch import nn

LEVELS = ((32, 16, (32, 64)), (8, 8, (64, 128)))  # centres, neighbours of each, widths
CODE, KIND = 128, 16


def shared(*widths: int) -> nn.Sequential:
    """The same layers for every point (..., width)."""
    layers: list[nn.Module] = []
    for a, b in zip(widths, widths[1:], strict=False):
        layers += [nn.Linear(a, b), nn.LayerNorm(b), nn.ReLU()]
    return nn.Sequential(*layers)


def gather(values: torch.Tensor, index: torch.Tensor) -> torch.Tensor:
    """Rows (B, ..., d) of ``values`` (B, n, d) by ``index`` (B, ...)."""
    first = torch.arange(len(values)).mul_(values.shape[1]).reshape(-1, *[1] * (index.dim() - 1))
    rows = (index + first).flatten()  # whole rows: faster than values.gather, which copies number by number
    return values.flatten(0, 1).index_select(0, rows).reshape(*index.shape, values.shape[-1])


class PointNet(nn.Module):
    """Clouds (B, n, 3) whose points stand in random order, and the number of the category of each (B,), to ``outputs`` numbers for each
    point (B, n, outputs). ``given``: further numbers that are known of each point (B, n, given)."""

    def __init__(self, categories: int, outputs: int = 1, given: int = 0) -> None:
        super().__init__()
        self.kind = nn.Embedding(categories, KIND)
        width, self.down, self.up = given, nn.ModuleList(), nn.ModuleList()
        skips = [given]
        for _, _, widths in LEVELS:
            self.down.append(shared(3 + 3 + width, *widths))
            width = widths[-1]
            skips.append(width)
        self.whole = shared(3 + width + KIND, CODE)
        above = CODE
        for skip in reversed(skips):
            self.up.append(shared(above + skip + 3 + KIND, 64))
            above = 64
        self.last = nn.Linear(64, outputs)

    def forward(self, points: torch.Tensor, category: torch.Tensor, given: torch.Tensor | None = None) -> torch.Tensor:
        kind = self.kind(category)[:, None]
        levels: list[tuple[torch.Tensor, torch.Tensor | None]] = [(points, given)]
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
        return self.last(found)


class PointActions(nn.Module):
    """Points (B, n, 3), categories (B,) and directions (B, n, k, 3), unit vectors, to (B, n, k): above 0, the point goes along."""

    def __init__(self, categories: int) -> None:
        super().__init__()
        self.points = PointNet(categories, outputs=64)
        self.action = nn.Sequential(shared(64 + 3, 64), nn.Linear(64, 1))

    def forward(self, points: torch.Tensor, category: torch.Tensor, ways: torch.Tensor) -> torch.Tensor:
        known = self.points(points, category)[:, :, None].expand(-1, -1, ways.shape[2], -1)
        return self.action(torch.cat([known, ways], dim=-1))[..., 0]


class Completer(nn.Module):
    """What is seen of objects (B, n, 3) to points on their whole surface: COARSE * FOLDS**2, folded from a small square about each of COARSE
    (after PCN, Yuan et al., 3DV 2018, and FoldingNet, Yang et al., CVPR 2018), and what is seen itself."""

    COARSE, FOLDS, CODE = 64, 2, 256

    def __init__(self) -> None:
        super().__init__()
        self.first = shared(3, 64, 128)
        self.second = shared(256, 128, self.CODE)
        self.coarse = nn.Sequential(shared(self.CODE, 256), nn.Linear(256, 3 * self.COARSE))
        self.told = nn.Linear(self.CODE, 64)
        self.place = nn.Linear(5, 64)
        self.fold = nn.Sequential(nn.ReLU(), shared(64, 64), nn.Linear(64, 3))
        side = torch.linspace(-0.03, 0.03, self.FOLDS)
        self.register_buffer("square", torch.cartesian_prod(side, side), persistent=False)
        nn.init.uniform_(
            self.coarse[-1].bias, -0.3, 0.3
        )  # spread from the start: where all stand in one place, all go the same way

    def forward(self, points: torch.Tensor) -> torch.Tensor:
        near = self.first(points)
        every = near.amax(dim=1, keepdim=True).expand(-1, points.shape[1], -1)
        code = self.second(torch.cat([near, every], dim=-1)).amax(dim=1)
        centre = self.coarse(code).reshape(len(points), self.COARSE, 3).repeat_interleave(len(self.square), dim=1)
        place = self.square.repeat(self.COARSE, 1).expand(len(points), -1, -1)
        away = self.fold(self.told(code)[:, None] + self.place(torch.cat([centre, place], dim=-1)))
        return torch.cat([points, centre + away], dim=1)


def chamfer(one: torch.Tensor, other: torch.Tensor) -> torch.Tensor:
    """CD-l1 of clouds (B, n, 3), (B, m, 3), their mean: half the sum of both mean distances from the nearest point of the other."""
    with torch.no_grad():
        square = (other * other).sum(dim=-1)[:, None] - 2.0 * one @ other.transpose(1, 2)
        theirs = square.argmin(dim=2)
        ours = square.add_((one * one).sum(dim=-1)[..., None]).argmin(dim=1)
    near = one - gather(other, theirs), other - gather(one, ours)
    return sum((away * away).sum(dim=-1).clamp_min(1e-12).sqrt().mean() for away in near) / 2
