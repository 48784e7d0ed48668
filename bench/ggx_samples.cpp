#include "ggx_samples.h"

SampleSource::SampleSource(double f0) : state_(1), p_{kTruth[ALPHA_X], kTruth[ALPHA_Y], kTruth[R_XY], f0}
{
}

/** splitmix64 (Steele, Lea, Flood 2014): tiny, and the same on every platform, which the distributions of std:: are not. */
double SampleSource::uniform()
{
    std::uint64_t z = (state_ += 0x9e3779b97f4a7c15u);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return static_cast<double>(((z ^ (z >> 31)) >> 11) + 1) * 0x1p-53;
}

double SampleSource::normal()
{
    const double radius = std::sqrt(-2 * std::log(uniform()));
    return radius * std::cos(2 * M_PI * uniform());
}

Sample SampleSource::next()
{
    const double cos_limit = std::cos(85 * M_PI / 180), degrees = 180 / M_PI;
    Sample s;
    s.theta_i = std::acos(1 - uniform() * (1 - cos_limit)) * degrees;
    s.phi_i = uniform() * 360;
    s.theta_o = std::acos(1 - uniform() * (1 - cos_limit)) * degrees;
    s.phi_o = uniform() * 360;
    const double f = ggx(p_, direction(s.theta_i, s.phi_i), direction(s.theta_o, s.phi_o));
    s.value = f * (1 + kNoise * normal());
    return s;
}
