// SPDX-License-Identifier: BSD-3-Clause
//
// Trees of revolute joints in Pinocchio, and seconds of processor time of n calls of its articulated-body algorithm and of its
// derivatives. The last coordinate moves by 1e-10 between calls, as the native loop of every contender has it.
#include <pinocchio/multibody.hpp>
#include <pinocchio/algorithm/aba-derivatives.hpp>
#include <pinocchio/algorithm/aba.hpp>
#include <ctime>
#include <string>

namespace pin = pinocchio;

struct Tree
{
    pin::Model model;
    pin::Data data;
    explicit Tree(const pin::Model &m) : model(m), data(m) {}
};

static double seconds()
{
    timespec now;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

using Vector = Eigen::Map<Eigen::VectorXd>;
using Three = Eigen::Map<const Eigen::Vector3d>;
using Nine = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>;

extern "C" Tree *tree_new(long n, long floating, const long *parents, const double *turns, const double *places,
                          const double *masses, const double *centers, const double *inertias, const double *gravity,
                          const double *trunk)
{
    pin::Model model;
    model.gravity.linear() = Three(gravity);
    pin::JointIndex base = 0;
    if (floating)
    {
        base = model.addJoint(0, pin::JointModelFreeFlyer(), pin::SE3::Identity(), "base");
        const pin::Inertia body(trunk[0], Three(trunk + 1), Nine(trunk + 4));
        model.appendBodyToJoint(base, body, pin::SE3::Identity());
    }
    for (long k = 0; k < n; k++) {
        const pin::JointIndex parent = parents[k] < 0 ? base : static_cast<pin::JointIndex>(parents[k] + 1) + base;
        const pin::SE3 place(Nine(turns + 9 * k), Three(places + 3 * k));
        const auto joint = model.addJoint(parent, pin::JointModelRZ(), place, "joint" + std::to_string(k));
        const pin::Inertia body(masses[k], Three(centers + 3 * k), Nine(inertias + 9 * k));
        model.appendBodyToJoint(joint, body, pin::SE3::Identity());
    }
    return new Tree(model);
}

extern "C" double tree_aba(long n, Tree *tree, double *q, double *v, double *out, long local)
{
    const pin::Model &m = tree->model;
    Eigen::VectorXd place = Vector(q, m.nq);
    const Eigen::VectorXd rate = Vector(v, m.nv), torque = Eigen::VectorXd::Zero(m.nv);
    const auto convention = local ? pin::Convention::LOCAL : pin::Convention::WORLD;
    const double last = place[m.nq - 1], start = seconds();
    volatile double sink = 0;
    for (long i = 0; i < n; i++) {
        place[m.nq - 1] = last + static_cast<double>(i & 1) * 1e-10;
        pin::aba(m, tree->data, place, rate, torque, convention);
        sink = tree->data.ddq[0];
    }
    const double taken = seconds() - start;
    (void)sink;
    place[m.nq - 1] = last;
    pin::aba(m, tree->data, place, rate, torque, convention);
    Vector(out, m.nv) = tree->data.ddq;
    return taken;
}

extern "C" double tree_derivatives(long n, Tree *tree, double *q, double *v, double *out)
{
    const pin::Model &m = tree->model;
    Eigen::VectorXd place = Vector(q, m.nq);
    const Eigen::VectorXd rate = Vector(v, m.nv), torque = Eigen::VectorXd::Zero(m.nv);
    Eigen::MatrixXd by_q = Eigen::MatrixXd::Zero(m.nv, m.nv), by_v = by_q;
    pin::Data::RowMatrixXs by_torque = pin::Data::RowMatrixXs::Zero(m.nv, m.nv);
    const double last = place[m.nq - 1], start = seconds();
    volatile double sink = 0;
    for (long i = 0; i < n; i++) {
        place[m.nq - 1] = last + static_cast<double>(i & 1) * 1e-10;
        pin::computeABADerivatives(m, tree->data, place, rate, torque, by_q, by_v, by_torque);
        sink = by_q(0, 0);
    }
    const double taken = seconds() - start;
    (void)sink;
    Eigen::Map<Eigen::Matrix<double, -1, -1, Eigen::RowMajor>>(out, m.nv, m.nv) = by_q;
    Eigen::Map<Eigen::Matrix<double, -1, -1, Eigen::RowMajor>>(out + m.nv * m.nv, m.nv, m.nv) = by_v;
    return taken;
}
