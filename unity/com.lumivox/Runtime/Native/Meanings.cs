// What numbers of the border's structs mean, for those that no enum of the package's names.
namespace Lumivox.Native
{
    internal partial struct LightSource
    {
        public const uint Directional = 0, Point = 1, Spot = 2;
        public const uint InverseSquare = 0, BuiltIn = 1;
    }

    internal partial struct Surroundings
    {
        public const uint Plain = 0, Gradient = 1, Studio = 2, Map = 3;
    }

    internal partial struct SavedView
    {
        public const uint Transparent = 0, Environment = 1, Plain = 2;
    }
}
