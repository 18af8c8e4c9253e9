# SPDX-License-Identifier: BSD-3-Clause
"""Models in Autolev's and MotionGenesis' language, written for these tests."""

PENDULUM = """\
% a rod on a pin with a motor
autoz on
Newtonian N
Bodies B
Constants g = 9.81, L, m, I
MotionVariables' theta', omega'
Specified T1
Simprot(N, B, 3, theta)
theta' = omega
W_B_N> = omega*N3>
P_NO_BO> = L/2*B1>
V_BO_N> = Dt(P_NO_BO>, N)
Mass B = m
Inertia B, 0, 0, I
Gravity(-g*N2>)
Torque(N/B, T1*N3>)
Zero = Fr() + FrStar()
Kane()
Input L = 50 cm, m = 2 kg, I = 0.1, theta = 30 deg, omega = 2 rad/s
Output T, theta deg
Code Dynamics() pendulum.c
"""

GENESIS_PENDULUM = """\
NewtonianFrame N
RigidBody B
Variable q''
Constant g = 9.81 m/s^2, L = 0.5 m
Specified T1
B.SetMass( m = 2 kg )
B.SetInertia( Bcm, Ixx = 0, Iyy = 0, Izz = 0.1 )
B.RotateZ( N, q )
Bo.Translate( No, 0> )
Bcm.Translate( Bo, L/2*Bx> )
System.AddForceGravity( -g*Ny> )
B.AddTorque( N, T1*Nz> )
SetGeneralizedSpeed( q' )
Dynamics = System.GetDynamicsKane()
Solve( Dynamics = 0, q'' )
Input q = 30 deg, q' = 2 rad/sec
ODE() pendulum.m
Quit
"""

DOUBLE = """\
MotionVariables' q{2}', u{2}'
Constants L, m{2}, g
Newtonian N
Frames A, B
Simprot(N, A, 3, q1); Simprot(N, B, 3, q2)
W_A_N> = u1*N3>; W_B_N> = u2*N3>
Point O
Particles P{2}
P_O_P1> = L*A1>
P_P1_P2> = &
   L*B1>
V_O_N> = 0>
V2pts(N, A, O, P1)
V2pts(N, B, P1, P2)
Mass P1 = m1, P2 = m2
q1' = u1
q2' = u2
Gravity(g*N1>)
Zero = Fr() + FrStar()
Kane()
"""

TENSION = """\
% the tension of a string by an auxiliary speed
Newtonian N
Frames A
Points O
Particles P
Constants L, m, g
Variables R, q'
MotionVariables' u{2}'
Simprot(N, A, 3, q)
q' = u1
W_A_N> = u1*N3>
V_O_N> = 0>
P_O_P> = L*A1>
V_P_N> = L*u1*A2> + u2*A1>
Auxiliary[1] = u2
Constrain(Auxiliary[u2])
Mass P = m
Force_P> = m*g*N1> + R*A1>
Zero = Fr() + FrStar()
Kane(R)
"""

SPIN = """\
% a body with products of inertia whose orientation is told by Euler parameters
Newtonian N
Bodies B
Variables e{4}'
MotionVariables' w{3}'
Constants m, J{6}, Tx
Dircos(N, B, Euler, e1, e2, e3, e4)
W_B_N> = w1*B1> + w2*B2> + w3*B3>
KinDiffs(N, B, Euler, e1, e2, e3, e4)
V_BO_N> = 0>
Mass B = m
Inertia B, J1, J2, J3, J4, J5, J6
Torque_B> = Tx*N1>
Zero = Fr() + FrStar()
"""

BLIND = """\
% the same body, which nobody orients
Newtonian N
Bodies B
MotionVariables' w{3}'
Constants m, J{6}
W_B_N> = w1*B1> + w2*B2> + w3*B3>
V_BO_N> = 0>
Mass B = m
Inertia B, J1, J2, J3, J4, J5, J6
Zero = Fr() + FrStar()
"""

SKATE = """\
% a knife edge on an inclined plane: a motion constraint
Newtonian N
Bodies B
MotionVariables' q{3}', u{3}'
Constants m, J, g
Simprot(N, B, 3, q3)
P_NO_BO> = q1*N1> + q2*N2>
q1' = u1
q2' = u2
q3' = u3
W_B_N> = u3*N3>
V_BO_N> = u1*N1> + u2*N2>
Dependent[1] = Dot(V_BO_N>, B2>)
Constrain(Dependent[u2])
Mass B = m
Inertia B, 0, 0, J
Gravity(g*N1>)
Zero = Fr() + FrStar()
"""

DRIVEN = """\
% a pendulum on a support that is moved
Newtonian N
Points S
Particles P
Frames A
Specified y''
Constants L, m, g, h, f
MotionVariables' q', u'
y = h*sin(f*t)
Simprot(N, A, 3, q)
q' = u
P_NO_S> = y*N2>
P_S_P> = L*A1>
V_P_N> = Dt(P_NO_P>, N)
Mass P = m
Gravity(-g*N2>)
Zero = Fr() + FrStar()
"""

GYROSTAT = """\
% a wheel whose angle nobody tracks, and a trace that drives nothing
Newtonian N
Bodies B, W
MotionVariables' w{3}', s'
Variables x'
Constants m, I{3}, J, T1
Simprot(B, W, 1, 0)
W_B_N> = w1*B1> + w2*B2> + w3*B3>
W_W_B> = s*B1>
V_BO_N> = 0>
V_WO_N> = V_BO_N>
x' = w1 + 2*w2
Mass B = m, W = m
Inertia B, I1, I2, I3
Inertia W, J, 0, 0
Torque(B/W, T1*B1>)
Zero = Fr() + FrStar()
Input w1 = 3, x = 2
"""

ROLLING = """\
NewtonianFrame A
RigidFrame B, C
RigidBody D
Point DA( D )
Constant g = 9.8 m/s^2, m = 2 kg, r = 0.3 m, I, J
Variable H', L', theta', x'', y'', wx', wy', wz'
SetUnitSystem( kg, meter, sec )
B.RotateZ( A, H )
C.RotateNegativeX( B, L )
D.RotateY( C, theta )
wD> = D.GetAngularVelocity( A )
Change[1] = wx - Dot( wD>, Cx> )
Change[2] = wy - Dot( wD>, Cy> )
Change[3] = wz - Dot( wD>, Cz> )
Solve( Change = 0, H', L', theta' )
D.SetAngularVelocityAcceleration( A, wx*Cx> + wy*Cy> + wz*Cz> )
Dcm.Translate( Ao, x*Ax> + y*Ay> + r*Cz> )
DA.SetPositionVelocity( Dcm, -r*Cz> )
Roll[1] = Dot( DA.GetVelocity(A), Ax> )
Roll[2] = Dot( DA.GetVelocity(A), Ay> )
SolveDt( Roll = 0, x', y' )
D.SetMass( m )
D.SetInertia( Dcm, C, J, I, J )
System.AddForceGravity( -g*Az> )
Dynamics = System.GetDynamicsKane()
"""

GENESIS_SPRING = """\
NewtonianFrame N
RigidBody B
Point P(), Q(B)
Constant k, b, L, J, m
Variable x', y', q', u{1:3}'
B.SetMass(m)
B.SetInertia(Bcm, J*(Bx>*Bx> + By>*By> + 2*Bz>*Bz>))
SetGeneralizedSpeed(u1, u2, u3)
x' = u1
y' = u2
q' = u3
B.Rotate(N, BodyZ, q)
Bcm.Translate(No, x*Nx> + y*Ny>)
Q.Translate(Bcm, 0>)
P.Translate(No, 0>)
Bcm.AddForceSpring(P, k, L)
Bcm.AddForceDamper(P, b)
B.AddTorque(3*Nz>)
partials = Bcm.GetPartialVelocity(N)
zero = System.GetDynamicsKane()
"""
