"""The derivation of the six numbers that are a pose."""

from __future__ import annotations

from ido_viz.derivations_text import Derivation, Equation

POSES = Derivation(
    "Poses as six numbers",
    "A pose is a turn and a shift. As a matrix it has many numbers that must fit together: add a little to each, and "
    "it is no turn any more. Six free numbers say the same, <i>ρ</i> for the shift and <i>φ</i> for the turn. Any six "
    "will do, so a linear map may add to them.",
    (
        "The pose <i>T</i> moves a scene point to where it is in the model's frame:",
        Equation(
            "pose-matrix",
            r"T = \begin{bmatrix} R & t \\ 0 & 1 \end{bmatrix}, \qquad p_{\text{model}} = R\,p_{\text{scene}} + t",
            "T is the matrix with the blocks R and t above 0 and 1; p model is R times p scene plus t",
        ),
        "<i>R</i> is a turn if it keeps lengths and does not mirror. All such poses are the group SE(3):",
        Equation(
            "rotation-conditions",
            r"R^{\top} R = I, \qquad \det R = 1",
            "R transposed times R is the identity, and the determinant of R is 1",
        ),
        "The arrow <i>φ</i>&nbsp;=&nbsp;<i>ψ&nbsp;u</i> points along the axis <i>u</i>, of length 1; its own length is "
        "the angle <i>ψ</i>, in radians. The hat makes a matrix of it, which takes the cross product:",
        Equation(
            "hat-matrix",
            r"\hat\varphi = \begin{bmatrix} 0 & -\varphi_z & \varphi_y \\ \varphi_z & 0 & -\varphi_x \\"
            r" -\varphi_y & \varphi_x & 0 \end{bmatrix}, \qquad \hat\varphi\,p = \varphi \times p",
            "phi hat is the matrix with rows 0, minus phi z, phi y; phi z, 0, minus phi x; "
            "minus phi y, phi x, 0; phi hat times p is the cross product of phi and p",
        ),
        "Now let a point turn and drift steadily, for one unit of the time <i>τ</i>:",
        Equation(
            "twist-motion",
            r"\frac{dp}{d\tau} = \varphi \times p + \rho",
            "the velocity of p is phi cross p plus rho",
        ),
        "This is linear, so its solution is the exponential of a matrix. It is always a pose, whatever the six "
        "numbers:",
        Equation(
            "pose-exponential",
            r"T = \exp \hat x, \qquad \hat x = \begin{bmatrix} \hat\varphi & \rho \\ 0 & 0 \end{bmatrix}",
            "T is the exponential of x hat, the matrix with the blocks phi hat and rho above zeros",
        ),
        "The series of exp closes up, because <i>û</i><sup>3</sup>&nbsp;=&nbsp;−<i>û</i>. This is the formula of "
        "Rodrigues:",
        Equation(
            "rodrigues-formula",
            r"R = I + \sin\psi\;\hat u + (1 - \cos\psi)\,\hat u^{\,2}",
            "R is the identity plus sine psi times u hat plus 1 minus cosine psi times u hat squared",
        ),
        "While it drifts, the point also turns, so the shift <i>t</i> is not <i>ρ</i>, but <i>ρ</i> times the mean of "
        "all the turns on the way (the paper's <i>J</i>):",
        Equation(
            "translation-matrix",
            r"\begin{aligned} t &= V\rho, \\ V &= \int_0^1 \exp(\tau\hat\varphi)\,d\tau \\"
            r" &= I + \frac{1 - \cos\psi}{\psi}\,\hat u + \Big(1 - \frac{\sin\psi}{\psi}\Big)\hat u^{\,2}"
            r" \end{aligned}",
            "t is V times rho; V is the integral from 0 to 1 of the exponential of tau phi hat, which is the identity "
            "plus 1 minus cosine psi over psi times u hat, plus 1 minus sine psi over psi, times u hat squared",
        ),
        "Without a turn, <i>V</i>&nbsp;=&nbsp;<i>I</i> and <i>t</i>&nbsp;=&nbsp;<i>ρ</i>.",
        "The way back, the logarithm, reads the angle and the axis off <i>R</i>. Below half a turn there is just one "
        "answer:",
        Equation(
            "pose-logarithm",
            r"\cos\psi = \frac{\operatorname{tr} R - 1}{2}, \quad \hat u = \frac{R - R^{\top}}{2 \sin\psi}, \quad"
            r" \rho = V^{-1} t",
            "cosine psi is trace of R minus 1, over 2; u hat is R minus R transposed over 2 sine psi; "
            "rho is the inverse of V times t",
        ),
        "An update adds to the six numbers, as in the paper. That is not the same as moving on by a second pose, "
        "because turns about two axes depend on their order.",
    ),
    "The six rows of <b>Maps</b> are ρx, ρy, ρz, φx, φy, φz; <b>Inspect</b> has the next update of each. In the code: "
    "<code>exp</code> and <code>log</code> in <code>ido/poses.py</code>.",
)
