using UnityEngine;

namespace Lumivox
{
    /// <summary>Turns of a running game.</summary>
    [AddComponentMenu("")]
    internal sealed class TickerBehaviour : MonoBehaviour
    {
        void Update() => Ticker.Tick();
    }
}
