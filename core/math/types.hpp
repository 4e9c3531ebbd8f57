#pragma once
// Names of the fixed-size matrices that mechanics is written in.
#include <Eigen/Core>
#include <Eigen/Geometry>

#include "core/math/dense_products.hpp"
#include "core/math/eigen_layout.hpp"

namespace flexopt {

template <class Scalar>
using Vector3 = Eigen::Matrix<Scalar, 3, 1>;
template <class Scalar>
using Matrix3 = Eigen::Matrix<Scalar, 3, 3>;
template <class Scalar>
using Matrix6 = Eigen::Matrix<Scalar, 6, 6>;

using Vector3d = Eigen::Vector3d;
using Matrix3d = Eigen::Matrix3d;
using VectorXd = Eigen::VectorXd;
using MatrixXd = Eigen::MatrixXd;
using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;
using Vector12d = Eigen::Matrix<double, 12, 1>;
using Matrix12d = Eigen::Matrix<double, 12, 12>;

}  // namespace flexopt
