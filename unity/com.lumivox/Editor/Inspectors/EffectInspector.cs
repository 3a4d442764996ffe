using System.Linq;
using UnityEditor;
using UnityEditor.UIElements;
using UnityEngine;
using UnityEngine.UIElements;

namespace Lumivox.Editor
{
    /// <summary>Shows an effect's settings without the struct that holds them, and what it is for.</summary>
    [CustomEditor(typeof(LumivoxEffect)), CanEditMultipleObjects]
    sealed class EffectInspector : UnityEditor.Editor
    {
        static readonly string[] settings = { "exposure", "targetSamples", "targetNoise", "frameBudgetMs", "resolutionScale", "writeDepth", "denoise", "keptLight", "environmentSource" };

        public override VisualElement CreateInspectorGUI()
        {
            var root = new VisualElement();
            var onCamera = targets.OfType<LumivoxEffect>().All(effect => effect.GetComponent<Camera>() != null);
            root.Add(new HelpBox(onCamera ? "Holds for this camera." : "Holds for all cameras that have none of their own.", HelpBoxMessageType.None) { name = "reach" });
            foreach (var name in settings) root.Add(new PropertyField(serializedObject.FindProperty("m_Settings." + name)));
            return root;
        }
    }
}
