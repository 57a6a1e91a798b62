"""Works that the methods of a study are cited from, by a short key."""

from typing import Final

#: Key in the text -> full reference.
REFERENCES: Final = {
    "Baker 2015": "Baker, J. W. (2015). Efficient analytical fragility function fitting using "
    "dynamic structural analysis. Earthquake Spectra 31(1), 579-599.",
    "Boore 2010": "Boore, D. M. (2010). Orientation-independent, nongeometric-mean measures of "
    "seismic intensity from two horizontal components of motion. Bulletin of the Seismological "
    "Society of America 100(4), 1830-1835.",
    "Caltrans 2013": "Caltrans (2013). Seismic Design Criteria, version 1.7.",
    "Caltrans 2019": "Caltrans (2019). Seismic Design Criteria, version 2.0.",
    "Cornell et al. 2002": "Cornell, C. A., Jalayer, F., Hamburger, R. O., Foutch, D. A. (2002). "
    "Probabilistic basis for 2000 SAC Federal Emergency Management Agency steel moment frame "
    "guidelines. Journal of Structural Engineering 128(4), 526-533.",
    "Dabaghi and Der Kiureghian 2018": "Dabaghi, M., Der Kiureghian, A. (2018). Simulation of "
    "orthogonal horizontal components of near-fault ground motion for specified earthquake source "
    "and site characteristics. Earthquake Engineering & Structural Dynamics 47(6), 1369-1393.",
    "Eads et al. 2015": "Eads, L., Miranda, E., Lignos, D. G. (2015). Average spectral "
    "acceleration as an intensity measure for collapse risk assessment. Earthquake Engineering & "
    "Structural Dynamics 44(12), 2057-2073.",
    "Efron and Tibshirani 1993": "Efron, B., Tibshirani, R. J. (1993). An Introduction to the "
    "Bootstrap. Chapman & Hall.",
    "Fieller 1954": "Fieller, E. C. (1954). Some problems in interval estimation. Journal of the "
    "Royal Statistical Society B 16(2), 175-185.",
    "Hilber et al. 1977": "Hilber, H. M., Hughes, T. J. R., Taylor, R. L. (1977). Improved "
    "numerical dissipation for time integration algorithms in structural dynamics. Earthquake "
    "Engineering & Structural Dynamics 5(3), 283-292.",
    "Holm 1979": "Holm, S. (1979). A simple sequentially rejective multiple test procedure. "
    "Scandinavian Journal of Statistics 6(2), 65-70.",
    "Houbolt 1950": "Houbolt, J. C. (1950). A recurrence matrix solution for the dynamic response "
    "of elastic aircraft. Journal of the Aeronautical Sciences 17(9), 540-550.",
    "Kowalsky and Priestley 2000": "Kowalsky, M. J., Priestley, M. J. N. (2000). Improved "
    "analytical model for shear strength of circular reinforced concrete columns in seismic "
    "regions. ACI Structural Journal 97(3).",
    "Mander et al. 1988": "Mander, J. B., Priestley, M. J. N., Park, R. (1988). Theoretical "
    "stress-strain model for confined concrete. Journal of Structural Engineering 114(8), "
    "1804-1826.",
    "McKenna et al. 2010": "McKenna, F., Scott, M. H., Fenves, G. L. (2010). Nonlinear "
    "finite-element analysis software architecture using object composition. Journal of Computing "
    "in Civil Engineering 24(1), 95-107.",
    "Newmark 1959": "Newmark, N. M. (1959). A method of computation for structural dynamics. "
    "Journal of the Engineering Mechanics Division 85(3), 67-94.",
    "Paulay and Priestley 1992": "Paulay, T., Priestley, M. J. N. (1992). Seismic Design of "
    "Reinforced Concrete and Masonry Buildings. Wiley.",
    "Rahman and Mackie 2023": "Rahman, A., Mackie, K. R. (2023). Node-to-node contact-friction "
    "problems using run-time parameter updates on a conventional force-deformation finite element. "
    "Finite Elements in Analysis and Design 218.",
    "Rahman and Mackie": "Rahman, A., Mackie, K. R. Modeling abutment contact-friction using "
    "run-time parameter updates.",
    "Schuirmann 1987": "Schuirmann, D. J. (1987). A comparison of the two one-sided tests "
    "procedure and the power approach for assessing the equivalence of average bioavailability. "
    "Journal of Pharmacokinetics and Biopharmaceutics 15(6), 657-680.",
    "Scott and Fenves 2006": "Scott, M. H., Fenves, G. L. (2006). Plastic hinge integration "
    "methods for force-based beam-column elements. Journal of Structural Engineering 132(2), "
    "244-252.",
    "Tobin 1958": "Tobin, J. (1958). Estimation of relationships for limited dependent variables. "
    "Econometrica 26(1), 24-36.",
    "Vamvatsikos and Cornell 2002": "Vamvatsikos, D., Cornell, C. A. (2002). Incremental dynamic "
    "analysis. Earthquake Engineering & Structural Dynamics 31(3), 491-514.",
    "Zhu et al. 2018": "Zhu, M., McKenna, F., Scott, M. H. (2018). OpenSeesPy: Python library for "
    "the OpenSees finite element framework. SoftwareX 7, 6-11.",
}
