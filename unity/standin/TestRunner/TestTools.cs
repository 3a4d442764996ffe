// The part of Unity's Test Framework that tests of packages name.
using System;
using NUnit.Framework;

namespace UnityEngine.TestTools
{
    /// A test that returns an IEnumerator: a frame goes by at each step of it.
    [AttributeUsage(AttributeTargets.Method)]
    public class UnityTestAttribute : NUnitAttribute { }

    /// Where a test runs; elsewhere it is passed over.
    [AttributeUsage(AttributeTargets.Assembly | AttributeTargets.Class | AttributeTargets.Method)]
    public class UnityPlatformAttribute : NUnitAttribute
    {
        public RuntimePlatform[] include { get; set; } = Array.Empty<RuntimePlatform>();
        public UnityPlatformAttribute(params RuntimePlatform[] include) => this.include = include;
    }
}
