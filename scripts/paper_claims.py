"""What the paper says of its examples, and what else the report (paper_report.py) compares with."""

from paper_examples import UNLIMITED

# Table 2, by jm.
TABLE2 = {
    0.5: (0.8073549, 0.9345453, 0.9595087, 0.9787287, 0.9913640, 1.0, 1.0),
    1.0: (0.8676084, 0.9241677, 0.9408307, 0.9681008, 0.9870096, 1.0, 1.0),
    2.0: (0.8455928, 0.8644630, 0.8922715, 0.9435270, 0.9764234, 1.0, 1.0),
    3.0: (0.7561741, 0.7701017, 0.8343928, 0.9099674, 0.9656469, 1.0, 1.0),
    UNLIMITED: (1.7662481, 1.7899937, 1.8854212, 1.3762555, 1.1042929, 1.0, 1.0),
}
# By how many per cent the largest deflection is said to be smaller for jm = 0.5 than for 1e20, by example.
CLAIMS = {1: 27.0, 2: 23.0}
# Example 1 with linear resultants (Bathe, Ramm and Wilson's model), converged: (time, tip deflection / L).
LINEAR_RESULTANTS = ((2.698e-3, 0.6016), (5.343e-3, -0.0103))
