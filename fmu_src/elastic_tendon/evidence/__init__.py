"""The proof that an FMU carries of itself, by the layered standard LS-REF of FMI.

In: a model, the recordings that it was compared with, the JSON of a diagnosis, a key to sign with.
Out: files for the FMU's folder extra/: experiments with reference results, errors, the range of
motion, parameters with covariance, provenance (`gather.py`); and a seal of all bytes (`seal.py`).
In: an FMU, ours or another maker's. Out: whether its bytes are as sealed, whether its own binary
reproduces what is stated, and where it was validated (`verify.py`).
"""
