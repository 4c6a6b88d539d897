"""The papers a report rests on: of the model, of the effects, of the statistics that judged."""

from collections.abc import Iterable, Iterator

from elastic_tendon import effects

MODEL = (
    "The model",
    "Dynamic Modeling of Elastic Tendon Actuators with Tendon Slackening; its equations (1) to "
    "(25), and (33) and (34) for parallel springs",
)
SOLVER = (
    "Simulation",
    "J. R. Dormand, P. J. Prince, A family of embedded Runge-Kutta formulae, Journal of "
    "Computational and Applied Mathematics 6(1), 1980; E. Hairer, G. Wanner, Solving Ordinary "
    "Differential Equations II, 2nd edition, Springer, 1996",
)
# what where the error lies is judged by
COMPARISON = (
    (
        "The missing torque",
        "E. T. Whittaker, On a new method of graduation, Proceedings of the Edinburgh "
        "Mathematical Society 41, 1923; P. H. C. Eilers, A perfect smoother, Analytical Chemistry "
        "75(14), 2003",
    ),
    (
        "How many independent samples there are",
        "C. J. Geyer, Practical Markov chain Monte Carlo, Statistical Science 7(4), 1992",
    ),
    (
        "Many tests at one error rate",
        "S. Holm, A simple sequentially rejective multiple test procedure, Scandinavian Journal of "
        "Statistics 6(2), 1979",
    ),
)
# what answers are ranked and confirmed by
DIAGNOSIS = (
    (
        "Evidence for an answer",
        "G. Schwarz, Estimating the dimension of a model, Annals of Statistics 6(2), 1978; R. E. "
        "Kass, A. E. Raftery, Bayes factors, Journal of the American Statistical Association "
        "90(430), 1995",
    ),
    (
        "The screen of all effects",
        "D. A. Messenger, D. M. Bortz, Weak SINDy: Galerkin-based data-driven model selection, "
        "Multiscale Modeling & Simulation 19(3), 2021",
    ),
    (
        "Whether a gain is chance",
        "S. G. Self, K.-Y. Liang, Asymptotic properties of maximum likelihood estimators and "
        "likelihood ratio tests under nonstandard conditions, Journal of the American Statistical "
        "Association 82(398), 1987",
    ),
    (
        "Gains on held-out data",
        "F. X. Diebold, R. S. Mariano, Comparing predictive accuracy, Journal of Business & "
        "Economic Statistics 13(3), 1995",
    ),
    (
        "Whether what remains depends on the machine",
        "J. G. MacKinnon, M. Ø. Nielsen, M. D. Webb, Fast and reliable jackknife and bootstrap "
        "methods for cluster-robust inference, Journal of Applied Econometrics 38(5), 2023; M. S. "
        "Bartlett, On the theoretical specification and sampling properties of autocorrelated "
        "time-series, Supplement to the Journal of the Royal Statistical Society 8(1), 1946",
    ),
    (
        "The experiment that decides",
        "A. C. Atkinson, V. V. Fedorov, The design of experiments for discriminating between two "
        "rival models, Biometrika 62(1), 1975",
    ),
)


def of_effects(effect_ids: Iterable[str]) -> Iterator[tuple[str, str]]:
    """Title and reference of effects, each once; what is no effect is left out."""
    for effect_id in dict.fromkeys(effect_ids):
        effect = effects.BY_ID.get(effect_id)
        if effect is not None and effect.reference:
            yield effect.title, effect.reference
