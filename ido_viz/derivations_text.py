"""The derivations as data: plain words first, then equations with what they say, then where to look.

Text is HTML with ``<i>`` for symbols, ``<b>`` for words of the page, ``<code>``, ``<sub>`` and ``<sup>``. After a
change of an equation's LaTeX run `python assets/make_equations.py`.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Equation:
    """An equation that ships as a drawing.

    Args:
        name: of its file, without the ending.
        tex: LaTeX that the drawing is made from.
        alt: how it is read aloud.
    """

    name: str
    tex: str
    alt: str


@dataclass(frozen=True, slots=True)
class Derivation:
    """One thing, derived.

    Args:
        title: as it is offered on the page.
        plain: what it says in plain words.
        steps: sentences and equations, in the order in which they are read.
        look: where to see it in the page and in the code.
    """

    title: str
    plain: str
    steps: tuple[str | Equation, ...]
    look: str


UPDATE_RULE = Derivation(
    "The update rule",
    "The method looks at the scene, and a learned table, the map, says how to change the pose. It looks again, from "
    "the new pose, and so on, until the change is tiny. No cost is minimised on the way, and no point is matched with "
    "another.",
    (
        "The pose is six numbers, three for the shift and three for the turn. We begin where the scene lies:",
        Equation("pose-vector", r"x = (\rho,\ \varphi) \in \mathbb{R}^6, \qquad x_0 = 0", "x is rho and phi, x 0 is 0"),
        "At the pose <i>x</i><sub><i>k</i></sub>, the histogram <i>h</i> is a long list of numbers, the bins. The map "
        "<i>D</i><sub><i>k</i>+1</sub> has six rows, and a column for each bin. It is trained to tell what is wrong "
        "with the pose, that is, how far <i>x</i><sub><i>k</i></sub> is from the true pose <i>x</i>*:",
        Equation(
            "map-predicts-error",
            r"D_{k+1}\,h(x_k) \;\approx\; x_k - x^{*}",
            "D k plus 1 times h of x k is about x k minus x star",
        ),
        "What is wrong is taken away. That is where the minus comes from:",
        Equation(
            "update-rule",
            r"x_{k+1} = x_k - D_{k+1}\,h(x_k)",
            "x k plus 1 is x k minus D k plus 1 times h of x k",
        ),
        "With a perfect map, one step would be enough:",
        Equation(
            "perfect-map",
            r"x_{k+1} = x_k - (x_k - x^{*}) = x^{*}",
            "x k plus 1 is x k minus, in brackets, x k minus x star, which is x star",
        ),
        "A real one is only roughly right. So the next one is trained on where this one left the training scenes.",
        "Gradient descent on a cost <i>E</i> has the same form. Here <i>D&nbsp;h</i> stands in for the slope, so "
        "nobody has to choose a cost:",
        Equation(
            "gradient-descent",
            r"x_{k+1} = x_k - \mu\,\frac{\partial E}{\partial x}(x_k)",
            "for comparison, gradient descent, where x k plus 1 is x k minus mu times the gradient of E at x k",
        ),
        "There are <i>K</i>&nbsp;=&nbsp;30 maps. Then the last one is used again, until the update is shorter than "
        "<i>ε</i>, or until the iteration limit:",
        Equation(
            "stopping-rule",
            r"\text{stop when}\quad \lVert D_K\,h(x_k) \rVert < \varepsilon",
            "stop when the length of D K times h of x k is less than epsilon",
        ),
    ),
    "<b>N</b> and <b>B</b> step. <b>Errors</b> has the length of each update, with <i>ε</i> dashed; <b>Methods and "
    "stopping</b> sets <i>ε</i>. In the code: <code>register</code> in <code>ido/registration.py</code>.",
)

HISTOGRAM = Derivation(
    "The histogram",
    "Every model point asks the scene: how much of you is in front of me, and how much behind? Near scene points count "
    "much, far ones nothing. Improved DO also asks of all scene points: how many lie higher than I, and how many "
    "further around the axis? All answers together are the histogram.",
    (
        "Move each scene point by the pose. Its weight falls with its distance to the model point "
        "<i>m</i><sub><i>a</i></sub>:",
        Equation(
            "scene-point-weight",
            r"s = R\,s_b + t, \qquad w_a(s) = e^{-\lVert s - m_a \rVert^2 / \sigma^2}",
            "s is R times s b plus t; its weight is e to the minus squared distance from s to m a over sigma squared",
        ),
        "With <i>σ</i><sup>2</sup>&nbsp;=&nbsp;0.03 the weight is 0.37 at a distance of 0.17, and 0.0002 at 0.5; below "
        "0.000001 it counts as nothing. The normal <i>n</i><sub><i>a</i></sub> decides the side:",
        Equation(
            "front-back-bins",
            r"\begin{aligned} h_a^{\text{front}} &= \sum_{n_a \cdot (s - m_a) \,>\, 0} w_a(s) \\"
            r" h_a^{\text{back}} &= \sum_{n_a \cdot (s - m_a) \,\le\, 0} w_a(s) \end{aligned}",
            "The bin front of a is the sum of the weights of all s with n a dot s minus m a greater than 0; "
            "the bin back is the sum over the others",
        ),
        "The other questions compare two angles, seen from the origin of the model: the elevation <i>θ</i> above the "
        "xy plane, and the azimuth <i>ω</i> around the z axis.",
        Equation(
            "elevation-azimuth",
            r"\begin{aligned} \theta(p) &= \text{atan2}\big(p_z, \sqrt{p_x^2 + p_y^2}\,\big) \\"
            r" \omega(p) &= \text{atan2}(p_y, p_x) \end{aligned}",
            "theta of p is atan 2 of p z and the root of p x squared plus p y squared; omega of p is atan 2 of p y "
            "and p x",
        ),
        "Here every point counts as one, however far it is. Down and anticlockwise get the rest:",
        Equation(
            "angle-bins",
            r"\begin{aligned} h_a^{\text{up}} &= \#\{s : \theta(s) > \theta(m_a)\} \\"
            r" h_a^{\text{clockwise}} &= \#\{s : \omega(s) > \omega(m_a)\} \end{aligned}",
            "The bin up of a is the number of s with theta of s greater than theta of m a; "
            "the bin clockwise is the number of s with omega of s greater than omega of m a",
        ),
        "(The names are the paper's. Seen from the tip of the z axis, a greater <i>ω</i> lies anticlockwise.)",
        "Each pair of sides is a block of 2<i>M</i> bins, for <i>M</i> model points. It is scaled to length 1, so that "
        "a scene with ten times as many points looks much the same:",
        Equation(
            "block-normalisation",
            r"h_{\text{block}} \;\leftarrow\; h_{\text{block}} \,/\, \lVert h_{\text{block}} \rVert",
            "each block of h is divided by its length",
        ),
        "The paper weighs the bins first, by what the model has on that side: first sides by <i>α</i>, <i>β</i>, "
        "<i>γ</i>, second sides by 1&nbsp;−&nbsp;<i>α</i>, 1&nbsp;−&nbsp;<i>β</i>, 1&nbsp;−&nbsp;<i>γ</i>.",
        Equation(
            "bin-weights",
            r"\begin{aligned} \alpha_a &= \tfrac{1}{M}\,\#\{m : n_a \cdot (m - m_a) > 0\} \\"
            r" \beta_a &= \tfrac{1}{M}\,\#\{m : \theta(m) > \theta(m_a)\} \\"
            r" \gamma_a &= \tfrac{1}{M}\,\#\{m : \omega(m) > \omega(m_a)\} \end{aligned}",
            "alpha a is the share of the model points m in front of m a; beta a the share with a greater theta; "
            "gamma a the share with a greater omega",
        ),
        "Most points of the bunny have less than a tenth of it in front of them. So <i>α</i> makes their front bins "
        "small, and the ridge then switches them off. We leave the weights out; <b>Improved DO (as printed)</b> has "
        "them.",
    ),
    "<b>Histograms</b> has every bin, and as a line what the model sees of itself. Click a grey point of the "
    "model to see its plane, cone and half-plane, and its bins in <b>Inspect</b>. In the code: <code>FrontBack</code> "
    "and <code>TripleBinary</code> in <code>ido/histograms.py</code>.",
)

LEARNING = Derivation(
    "Learning a map",
    "We make many scenes and know the true pose of each. The map should tell, from the histogram alone, what is wrong "
    "with each pose. Its guess is a sum: every bin times a learned number. The numbers are the best ones over all "
    "scenes; a small penalty, the ridge, keeps them small, so that chance patterns are not learned by heart.",
    (
        "For the training scenes <i>i</i>&nbsp;=&nbsp;1&nbsp;…&nbsp;<i>N</i>, write for short, at the poses reached "
        "so far:",
        Equation(
            "training-pair",
            r"h_i = h(x_i), \qquad e_i = x_i - x_i^{*}",
            "h i is the histogram at x i, e i is x i minus x i star",
        ),
        "After the update, <i>e</i><sub><i>i</i></sub>&nbsp;−&nbsp;<i>D&nbsp;h</i><sub><i>i</i></sub> is still wrong. "
        "Its mean square should be small, and so should <i>D</i>:",
        Equation(
            "ridge-objective",
            r"F(D) = \frac{1}{N} \sum_{i} \lVert e_i - D\,h_i \rVert^2 + \lambda \lVert D \rVert_F^2",
            "F of D is the mean over i of the squared length of e i minus D h i, plus lambda times the sum of the "
            "squares of D",
        ),
        "<i>F</i> is a bowl, because <i>λ</i>&nbsp;&gt;&nbsp;0. At its one lowest point the gradient is zero:",
        Equation(
            "ridge-gradient",
            r"-\frac{2}{N} \sum_{i} (e_i - D\,h_i)\,h_i^{\top} + 2\lambda D = 0",
            "minus 2 over N times the sum over i of e i minus D h i, times h i transposed, plus 2 lambda D, is 0",
        ),
        "Bring what has <i>D</i> to one side. The second bracket can be inverted, again because "
        "<i>λ</i>&nbsp;&gt;&nbsp;0:",
        Equation(
            "ridge-solution",
            r"D = \Big[\frac{1}{N} \sum_{i} e_i h_i^{\top}\Big]"
            r"\Big[\frac{1}{N} \sum_{i} h_i h_i^{\top} + \lambda I\Big]^{-1}",
            "D is the mean of e i times h i transposed, times the inverse of the mean of h i times h i transposed "
            "plus lambda times the identity",
        ),
        "<b>Why the error falls (Theorem 1).</b> The best map is no worse than <i>D</i>&nbsp;=&nbsp;0, which moves "
        "nothing:",
        Equation(
            "error-falls",
            r"\underbrace{\frac{1}{N} \sum_{i} \lVert e_i - D\,h_i \rVert^2}_{\text{error after}} + "
            r"\lambda \lVert D \rVert_F^2 \;\le\; "
            r"\underbrace{\frac{1}{N} \sum_{i} \lVert e_i \rVert^2}_{\text{error before}}",
            "The error after the update plus lambda times the squares of D is at most the error before",
        ),
        "So the training error falls by at least the term with <i>λ</i>, unless <i>D</i>&nbsp;=&nbsp;0. That happens "
        "only if the first bracket above is zero. It is not, if some map leads every scene the right way, as the "
        "paper assumes.",
        "<b>As the paper prints it,</b> the map is another one:",
        Equation(
            "ridge-as-printed",
            r"D_{\text{printed}} = \frac{1}{N} \sum_{i} \frac{(x_i^{*} - x_i)\,h_i^{\top}}"
            r"{\lambda + h_i^{\top} h_i}",
            "D printed is the mean over i of x i star minus x i, times h i transposed, over lambda plus h i transposed "
            "times h i",
        ),
        "Its sign is the opposite, which leads away from <i>x</i>*; and it divides scene by scene. That is right for "
        "a single scene, but for the sign. For more, it does not minimise <i>F</i>. We use the closed form above.",
    ),
    "<b>Training</b> has the error after each map; <b>Maps</b> has <i>D</i>. The lesson <b>Learned by heart</b> shows "
    "what too few scenes do. In the code: <code>solve</code> in <code>ido/training.py</code>.",
)

ATTRIBUTION = Derivation(
    "Which bin did it?",
    "An update is a sum, with one part from every bin. So it can be read like a bill: each item has its price, and "
    "together they make the total, exactly. Some parts pull against the others.",
    (
        "A matrix times a vector is a sum over the columns:",
        Equation(
            "update-as-sum",
            r"\Delta x = -D\,h = \sum_{j} c_j, \qquad c_j = -D_{:,\,j}\, h_j",
            "Delta x is minus D h, the sum over the bins j of c j, which is minus column j of D times h j",
        ),
        "The share <i>c</i><sub><i>j</i></sub> of bin <i>j</i> is six numbers, one for each of <i>x</i>. To compare "
        "bins, ask how far each leads along a direction <i>d</i> of length 1:",
        Equation("share-along-direction", r"v_j = d^{\top} c_j", "v j is d transposed times c j"),
        "Along the update itself, the shares add up to its length. Red bins push on, blue ones pull back:",
        Equation(
            "shares-add-up",
            r"d = \frac{\Delta x}{\lVert \Delta x \rVert} \quad\Rightarrow\quad \sum_{j} v_j = \lVert \Delta x \rVert",
            "with d as Delta x over its length, the sum of all v j is the length of Delta x",
        ),
        "Along the way to the true pose, <i>d</i> points from <i>x</i> to <i>x</i>*. A negative share then "
        "leads astray:",
        Equation(
            "direction-to-truth",
            r"d = \frac{x^{*} - x}{\lVert x^{*} - x \rVert}",
            "d is x star minus x, over its length",
        ),
        "<b>Against the reference.</b> Most bins are not empty even in place. Split off the reference line "
        "<i>r</i>, what the model sees of itself:",
        Equation(
            "shares-against-reference",
            r"\Delta x = \underbrace{-\sum_{j} D_{:,\,j}\,(h_j - r_j)}_{\text{what differs from the line}}"
            r"\quad\underbrace{-\;D\,r}_{\text{same for every scene}}",
            "Delta x is minus the sum over j of column j of D times h j minus r j, which is what differs from the "
            "line, minus D r, which is the same for every scene",
        ),
        "The last part is the update that the map would make with the model exactly in place. From map to map, "
        "training drives it towards zero: for DO on the bunny from 0.12 to 0.004. So these shares add up to "
        "Δ<i>x</i>&nbsp;+&nbsp;<i>D&nbsp;r</i>, not quite to Δ<i>x</i>.",
        "The bill is exact, but it is no proof of a cause. Bins next to each other see nearly the same; without one, a "
        "map would have been learned that leans on the others.",
    ),
    "<b>Inspect</b> has the shares of the blocks and the strongest bins, and colours the model by the sum of the bins "
    "of each point. In the code: <code>Attribution</code> in <code>ido/attribution.py</code>.",
)
