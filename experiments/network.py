"""A small PointNet++: two levels of neighbourhoods, a code of the whole cloud, and back up to the points."""

from __future__ import annotations

import torch
from torch import nn

LEVELS = ((48, 16, (32, 64)), (12, 8, (64, 128)))  # centres, neighbours of each, widths
CODE, WIDTH, KIND = 128, 64, 16


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
            self.down.append(Down(width, *widths))
            width = widths[-1]
            skips.append(width)
        self.whole = shared(3 + width + KIND, CODE)
        above = CODE
        for skip in reversed(skips):
            self.up.append(Up(above, skip + 3))
            above = WIDTH
        self.last = nn.Sequential(shared(WIDTH, WIDTH), nn.Linear(WIDTH, outputs))

    def forward(self, points: torch.Tensor, category: torch.Tensor, given: torch.Tensor | None = None) -> torch.Tensor:
        kind = self.kind(category)[:, None]
        levels: list[tuple[torch.Tensor, torch.Tensor | None]] = [(points, given)]
        for (count, near, _), layer in zip(LEVELS, self.down, strict=True):
            above, features = levels[-1]
            centres = above[:, :count]  # in random order, the first ones are a random choice
            levels.append((centres, layer(above, features, centres, near)))
        centres, features = levels[-1]
        assert features is not None
        code = self.whole(torch.cat([centres, features, kind.expand(-1, centres.shape[1], -1)], dim=-1)).amax(
            dim=1, keepdim=True
        )
        found, below = code, centres[:, :1]
        for (place, own), layer in zip(reversed(levels), self.up, strict=True):
            found = layer(found, below, place if own is None else torch.cat([place, own], dim=-1), kind)
            below = place
        return self.last(found)


class Down(nn.Module):
    """Of points (B, n, 3), with what is known of them (B, n, given), to centres among them (B, m, 3): the ``near`` nearest points of each."""

    def __init__(self, given: int, hidden: int, width: int) -> None:
        super().__init__()
        self.point, self.centre = nn.Linear(3 + given, hidden), nn.Linear(3, hidden)
        self.pair, self.own = nn.Linear(hidden, width, bias=False), nn.Linear(3, width)
        self.norm = nn.LayerNorm(width)

    def forward(
        self, points: torch.Tensor, given: torch.Tensor | None, centres: torch.Tensor, near: int
    ) -> torch.Tensor:
        index = torch.cdist(centres, points).topk(near, largest=False, sorted=False).indices
        known = self.point(points if given is None else torch.cat([points, given], dim=-1))  # once a point, not a pair
        pairs = (gather(known, index) - self.centre(centres)[:, :, None]).relu_()
        return nn.functional.relu(self.norm(self.pair(pairs).max(dim=2).values + self.own(centres)))


class Up(nn.Module):
    """What is known at some points (B, m, above), spread to more of them by weights that fall with the fourth power of the distance, with what
    these know of themselves (B, n, own), their places first, and the category's code (B, 1, KIND)."""

    def __init__(self, above: int, own: int) -> None:
        super().__init__()
        self.above, self.own, self.kind = nn.Linear(above, WIDTH), nn.Linear(own, WIDTH), nn.Linear(KIND, WIDTH)
        self.norm = nn.LayerNorm(WIDTH)

    def forward(self, found: torch.Tensor, at: torch.Tensor, own: torch.Tensor, kind: torch.Tensor) -> torch.Tensor:
        # what is linear comes before what is spread: there are fewer points there, and no neighbours to gather
        known = self.above(found) + self.kind(kind)
        weight = torch.cdist(own[..., :3].detach(), at).square_().add_(1e-5).square_().reciprocal_()
        spread = torch.baddbmm(self.own(own), weight / weight.sum(dim=-1, keepdim=True), known)
        return nn.functional.relu(self.norm(spread))


class PointActions(nn.Module):
    """Points (B, n, 3), categories (B,) and directions (B, n, k, 3), unit vectors, to (B, n, k): above 0, the point goes along."""

    def __init__(self, categories: int) -> None:
        super().__init__()
        self.points = PointNet(categories, outputs=64)
        self.way = nn.Linear(3, 64)
        self.action = nn.Sequential(nn.ReLU(), nn.Linear(64, 1))

    def forward(self, points: torch.Tensor, category: torch.Tensor, ways: torch.Tensor) -> torch.Tensor:
        return self.action(self.points(points, category)[:, :, None] + self.way(ways))[..., 0]


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
