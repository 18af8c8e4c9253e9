# SPDX-License-Identifier: BSD-3-Clause
"""Whole programs as users of MotionGenesis and Autolev write them, with what they define on the way; written for these tests."""

CART = """\
% two wheels on an axle; nobody tracks where the cart is, and the program ends before the rest of a template
SetWorkingDirectory(/tmp)
NewtonianFrame N
RigidBody A, B, C
Point BN( B ), CN( C )
Variable v', w', wB', wC'
Constant R = 0.35 m, b = 0.75 m, a = 1.6 m
Constant drag = 3 s^-1
A.SetMass( mA = 640 kg )
B.SetMass( m = 30 kg )
C.SetMass( m )
A.SetInertia( Acm, 0, 0, IA = mA*a^2/12 )
B.SetInertia( Bcm, A, K = 1 kg*m^2, J = 2 kg*m^2, K )
C.SetInertia( Ccm, A, K, J, K )
A.SetAngularVelocity( N, w*Az> )
B.SetAngularVelocity( A, wB*Ay> )
C.SetAngularVelocity( A, wC*Ay> )
Ao.SetVelocityAcceleration( N, v*Ax> )
Acm.Translate( Ao, a*Ax> )
Bcm.Translate( Ao, -b*Ay> )
Ccm.Translate( Ao, b*Ay> )
BN.SetPositionVelocity( Bcm, -R*Az> )
CN.SetPositionVelocityAcceleration( Ccm, -R*Az> )
Roll[1] = Dot( BN.GetVelocity(N), Ax> )
Roll[2] = Dot( CN.GetVelocity(N), Ax> )
SolveDt( Roll = 0, wB, wC )
Ao.AddForce( -drag*mA*v*Ax> )
SetGeneralizedSpeeds( v, w )
B.GetRotationMatrix( A )
Eq = System.GetDynamicsKane()
Solve( System.GetGeneralizedEffectiveForce() = 0, w', v' )
EvaluateToNumber( Eq[1], v = 1 )
ODE( Eq := 0, v', w' ) cart
Quit
A.AddTorque( SomeVector> )
"""

ARM = """\
% a bob on a rod whose second angle is prescribed, as its rate is among no generalized speeds; the rods have no mass
NewtonianFrame N
RigidBody A, B
Particle Q
Variable qA'', qB''
Constant L, I
A.SetMass( 0 )
B.SetMass( 0 )
Q.SetMass( m )
A.SetInertia( Acm, 0, I, 0 )
B.SetInertia( Bcm, 0, 0, 0 )
A.RotateY( N, qA )
B.RotateNegativeZ( A, qB )
Bo.SetVelocityAcceleration( N, 0> )
Q.Translate( Bo, -L*By> )
SetGeneralizedSpeeds( qA' )
eq = System.GetDynamicsKane()
"""

TUMBLING = """\
% an orientation that stands still and an angular velocity: it turns from there
NewtonianFrame N
RigidBody B
Variable wx', wy', wz', vx'
Constant tilt, c
Constant I1, I2, I3
B.SetMass( m )
B.SetInertia( Bcm, I1, I2, I3 )
B.RotateZ( N, tilt )
Bcm.SetVelocity( N, vx*Nx> )
B.SetAngularVelocityAcceleration( N, wx*Bx> + wy*By> + wz*Bz> )
B.AddTorque( -c*wx*Bx> )
zero = System.GetDynamicsKane()
"""

GIVEN_CENTRE = """\
% a mass centre that moves as it is told: other points of its body go with it
NewtonianFrame N
RigidBody A
Point P( A )
Variable q'', s
Constant L, h, c, F, I
A.SetMass( m )
A.SetInertia( Acm, 0, 0, I )
A.RotateZ( N, q )
Ao.SetPosition( No, L*Nx> )
Acm.SetPosition( Ao, h*Ax> )
P.SetPosition( Ao, L*Ax> )
Acm.SetVelocityAcceleration( N, c*q'*Nx> )
P.AddForce( F*Ny> )
zero = System.GetDynamicsKane()
"""

LOOP = """\
% two bars that meet: the forces between them are unknowns beside accelerations, the loop is among the equations
NewtonianFrame N
RigidBody A, B
Point AB( A ), BA( B )
Constant L = 1 m, d = 1.5 m, g = 9.81 m/s^2
Variable qA'', qB'', Fx, Fy
A.SetMassInertia( mA = 2 kg, 0, IA = mA*L^2/12, IA )
B.SetMassInertia( mB = 3 kg, 0, IB = mB*L^2/12, IB )
A.RotateZ( N, qA )
B.RotateZ( N, qB )
Ao.Translate( No, 0> )
Acm.Translate( Ao, 0.5*L*Ax> )
AB.Translate( Ao, L*Ax> )
Bo.Translate( No, d*Nx> )
Bcm.Translate( Bo, 0.5*L*Bx> )
BA.Translate( Bo, L*Bx> )
System.AddForceGravity( -g*Ny> )
BA.AddForce( AB, Fx*Nx> + Fy*Ny> )
Loop = Dot( AB.GetPosition(No) - BA.GetPosition(No), Ny> )
Dynamics[1] = Dot( Nz>, A.GetDynamics(Ao) )
Dynamics[2] = Dot( Nz>, B.GetDynamics(Bo) )
LoopDtDt = Dt( Dt( Loop ) )
SolveSetInput( Loop = 0, qA = 50 deg, qB = 130 deg )
ODE( [Dynamics; LoopDtDt] = 0, qA'', qB'', Fy ) bars.m
"""

STRINGS = """\
% coordinates with one prime whose rates are speeds, constants with values in Mass, words cut at the ends of lines
Newtonian N
Frames A, B
Particles P, Q
Points O
MotionVariables q{2}'
Specifieds Phi
Constants length, g
Mass P = mP = 10, Q = mQ = 20
Simprot(N, A, 3, q1)
Simprot(N, B, 3, q2)
P_O_P> = length*A1>
P_P_Q> = len&
   gth*B1>
w_A_N> = q1'*A3>
w_B_N> = q2'*B3>
v_O_N> = 0>
v2pts(N, A, O, P)
v2pts(N, B, P, Q)
Gravity(g*N1>)
Zero = Fr() + FrStar()
Perturb = Taylor(Zero, 1, q1=0:d1, q2=0:d2)
Solve(Zero, q{1:2}'')
Input q1 = inputVector[1], length = 2
"""

LEG = """\
% prescribed joints whose torques auxiliary speeds bring into evidence, with a force on the mass centre of all bodies
Newtonian N
Bodies T, E, F
Points O, K, CM
Variables q', u{3}', SH, SK
Constants mT, mE, mF, JE, JF, L, g, pull
Specified EA'', FA''
Mass T = mT, E = mE, F = mF
Inertia T, 0, 0, 0
Inertia E, 0, 0, JE
Inertia F, 0, 0, JF
Simprot(N, T, 3, 0)
Simprot(T, E, 3, EA)
Simprot(E, F, 3, FA)
q' = u1
W_E_T> = EA'*N3> + u2*N3>
W_F_E> = FA'*N3> + u3*N3>
P_O_TO> = q*N1>
P_TO_EO> = L*E1>
P_TO_K> = 2*L*E1>
P_K_FO> = L*F1>
P_O_CM> = CM(O)
V_O_N> = 0>
V_TO_N> = Dt(P_O_TO>, N)
V_EO_N> = Dt(P_O_EO>, N)
V_K_N> = Dt(P_O_K>, N)
V_FO_N> = Dt(P_O_FO>, N)
V_CM_N> = Dt(P_O_CM>, N)
Gravity(-g*N2>)
Force(CM, pull*N2>)
Torque(T/E, SH*N3>)
Torque(E/F, SK*N3>)
Auxiliary[1] = u2
Auxiliary[2] = u3
Constrain(Auxiliary[u2, u3])
Zero = Fr() + FrStar()
Kane(SH, SK)
"""

PLACEHOLDERS = """\
Newtonian N
Bodies B
MotionVariables' w{3}'
Constants m, Ixx, Iyy, Izz, Ixy, Iyz, Ixz
W_B_N> = w1*B1> + w2*B2> + w3*B3>
A_BO_N> = 0>
Mass B = m
Inertia B, Ixx, Iyy, Izz, Ixy, Iyz, Ixz
Zero = Fr() + FrStar()
Input m = 1, Ixx = 1, Iyy = 1, Izz = 1, Ixy = 1, Iyz = 1, Ixz = 1
"""

BASE = """\
% a rod whose base stands still at a place of its own; the forces there by auxiliary speeds
Newtonian N
Bodies A
Points O, J{2}o
Variables q{3}', u{3}', Rx, Ry
Constants m, g, L, IA
Mass A = m
Inertia A, 0, 0, IA
Simprot(N, A, 3, q3)
q1' = u1
q2' = u2
q3' = u3
W_A_N> = u3*N3>
P_O_J1o> = q1*N1> + q2*N2>
P_J1o_J2o> = L*A1>
P_J2o_Ao> = L*A1>
V_O_N> = 0>
V_J1o_N> = Dt(P_O_J1o>, N)
V_Ao_N> = Dt(P_O_Ao>, N)
Gravity(-g*N2>)
Force(J1o, Rx*N1> + Ry*N2>)
Auxiliary[1] = u1
Auxiliary[2] = u2
Constrain(Auxiliary[u1, u2])
Zero = Fr() + FrStar()
Kane(Rx, Ry)
"""

OBLIQUE = """\
% a body on an oblique axis, by Rodrigues parameters
Newtonian N
Bodies B
MotionVariables' q', u'
Constants m, g, L, I{3}, a{3}
Dircos(N, B, Rodrigues, a1*tan(q/2), a2*tan(q/2), a3*tan(q/2))
q' = u
Angvel(N, B)
P_No_Bo> = L*B1>
V_Bo_N> = Dt(P_No_Bo>, N)
Mass B = m
Inertia B, I1, I2, I3
Gravity(-g*N3>)
Zero = Fr() + FrStar()
"""

COSINES = """\
% a body oriented by nine direction cosines, along one of which a force stays
Newtonian N
Bodies B
MotionVariables' w{3}', C{1:3,1:3}'
Constants m, F, I{3}
W_B_N> = w1*B1> + w2*B2> + w3*B3>
KinDiffs(N, B, Poisson, C11, C12, C13, C21, C22, C23, C31, C32, C33)
V_BO_N> = 0>
Mass B = m
Inertia B, I1, I2, I3
Torque_B> = F*(C11*B1> + C12*B2> + C13*B3>) + F*C21*N2>
Zero = Fr() + FrStar()
"""
