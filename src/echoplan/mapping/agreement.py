"""Agreement: whether all that was heard fits together, as it does from exact poses."""

import numpy as np

from echoplan.mapping.account import Account
from echoplan.mapping.copies import without_copies
from echoplan.mapping.independence import intraclass_correlation

__all__ = ["agreement", "agrees", "evidence", "is_doubtful", "is_torn"]


def agreement(account: Account) -> float:
    """Tell how many of the pings of arcs features or their ghosts explain.

    Parameters
    ----------
    account : Account
        What was heard, and what is made of it.

    Returns
    -------
    float
        Their share; 1 without arcs.
    """
    heard = np.concatenate([arc.pings for arc in account.arcs]) if account.arcs else np.zeros(0, dtype=np.int64)
    return float(account.explained(account.features)[heard].mean()) if len(heard) else 1.0


def agrees(account: Account) -> bool:
    """Tell whether the pings fit together.

    Parameters
    ----------
    account : Account
        What was heard, and what is made of it.

    Returns
    -------
    bool
        Whether most are explained, by readings that scatter as usual.
    """
    usual = max(account.settings.first_noise, 0.9 * account.resolution)
    return agreement(account) >= account.settings.agreement and account.noise <= usual


def is_torn(account: Account) -> bool:
    """Tell whether many walls are there twice: poses that drift do that.

    Parameters
    ----------
    account : Account
        What was heard, and what is made of it.

    Returns
    -------
    bool
        Whether they are.
    """
    walls = [each for each in account.features if each.is_wall]
    copies = len(walls) - len(without_copies(walls, account.settings.copies))
    return copies > account.settings.torn * len(walls)


def is_doubtful(account: Account) -> bool:
    """Tell whether poses may be wrong: pings do not fit together, or those of a station err together.

    Parameters
    ----------
    account : Account
        What was heard, and what is made of it.

    Returns
    -------
    bool
        Whether they may be.
    """
    if not agrees(account) or account.adjusted is None:
        return True
    if not account.memory.is_empty:
        # What was trusted so far is doubted again only if pings do not agree.
        return False
    owners, left = account.adjusted.owners, account.adjusted.residuals
    common = intraclass_correlation(account.soundings, owners, left, noise=account.noise)
    return common > account.settings.shared_error


def evidence(account: Account) -> float:
    """Tell how much better features explain the pings than nothing does, less what free poses cost.

    Each free parameter costs half of the logarithm of the number of readings that tell it (Schwarz 1978).

    Parameters
    ----------
    account : Account
        What was heard, and what is made of it.

    Returns
    -------
    float
        Logarithm of a ratio of likelihoods [nats].
    """
    gains = account.explanation.levels(account.features) - account.explanation.floor
    cost = 0.0
    if account.believed is not None:
        heard = np.bincount(account.soundings.stations[gains > 0.0], minlength=len(account.given))
        cost = 1.5 * float(np.log(np.maximum(heard[1:], 1)).sum())
    return float(account.soundings.weights @ gains) - cost
