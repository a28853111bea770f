"""Names of the vectors of a workspace, rows of one array (23, d), as in ``w.vectors[row.FORCES, i]``."""

FORCES = 0  # Q
NORMAL = 1  # D_n
TANGENTIAL = 2  # D_tau
FREE_ACCELERATION = 3  # M^-1 Q
NORMAL_RESPONSE = 4  # M^-1 D_n^T, or S^-1 D_n^T in an implicit step
TANGENTIAL_RESPONSE = 5
ACCELERATION = 6  # q''
SUPPLY = 7  # derivative of the supplied power over q''
RESIDUAL = 8  # Q + D^T lambda - M q'' of an implicit step
INCREMENT = 9  # of q'' in an implicit step
PRODUCT_A, PRODUCT_B = 10, 11  # products with the mass matrix
SCRATCH_A, SCRATCH_B, SCRATCH_C = 12, 13, 14  # for what the system's methods need in between
RANK_ONE = 15  # and 16, 17: S^-1 of a system's rank-one vector, for each effective matrix
# of the beam in its floating frame, behind the entry of theta: its matrices times B
SPIN_PRODUCT, GRAVITY_PRODUCT, STIFFNESS_PRODUCT, SHORTENING_PRODUCT = 18, 19, 20, 21
DAMPING_PRODUCT = 22  # times B'
VECTORS = 23
