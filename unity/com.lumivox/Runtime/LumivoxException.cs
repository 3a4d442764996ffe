using System;

namespace Lumivox
{
    /// <summary>Something that Lumivox could not do; the message says why and what helps, and may be shown as it is.</summary>
    public sealed class LumivoxException : Exception
    {
        /// <summary>One with a message.</summary>
        public LumivoxException(string message) : base(message) { }
    }
}
